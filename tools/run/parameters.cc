#include "tools/run/parameters.h"

#include <cstdio>
#include <cstdlib>

#include "modules/frontend/frontend_params.h"
#include "modules/health/health_params.h"
#include "modules/mapping/mapping_params.h"
#include "modules/matching/matching_params.h"
#include "modules/standstill/standstill_params.h"
#include "modules/tracking/tracking_params.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// Calls visit(group, struct, rows) for every group: the only place that knows them all.
template <class Params, class Visit>
void for_each_group(Params& p, Visit&& visit) {
  visit("door", p.door, kDoorRows);
  visit("imu", p.imu, kImuRows);
  visit("frontend", p.frontend, kFrontendRows);
  visit("stereo", p.tracking.stereo, kStereoRows);
  visit("tracker", p.tracking.tracker, kTrackerRows);
  visit("filter", p.tracking.filter, kFilterRows);
  visit("matching", p.tracking.matching, kMatchingRows);
  visit("standstill", p.tracking.standstill, kStandstillRows);
  visit("health", p.tracking.health, kHealthRows);
  visit("mapping", p.mapping, kMappingRows);
}

}  // namespace

void set_parameter(AppParams& params, const std::string& assignment) {
  const size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  const std::string text = equals == std::string::npos ? "" : assignment.substr(equals + 1);
  char* end = nullptr;
  const float value = std::strtof(text.c_str(), &end);
  if (text.empty() || *end != '\0') {
    throw InputError("not a parameter and a number", "--set " + assignment, "use name=value");
  }
  int found = 0;
  for_each_group(params, [&](const std::string& group, auto& values, const auto& rows) {
    for (const auto& row : rows) {
      if (name != row.name && name != group + "." + row.name) continue;
      ++found;
      if (set_param(values, rows, row.name, value) == Status::kOk) continue;
      char range[96];
      std::snprintf(range, sizeof range, "choose %g to %g", row.min, row.max);
      throw InputError("out of range", "--set " + assignment, range);
    }
  });
  if (found == 0) {
    throw InputError("no such parameter", "--set " + assignment, "pirvs params lists them");
  }
  if (found > 1) {
    throw InputError("several groups have it", "--set " + assignment, "write group.name=value");
  }
}

std::string list_parameters(const AppParams& params) {
  std::string out;
  for_each_group(params, [&](const char* group, const auto& values, const auto& rows) {
    for_each_param(values, rows, [&](const auto& row, float value) {
      const std::string name = std::string(group) + "." + row.name;
      char line[256];
      std::snprintf(line, sizeof line, "%-36s %10g  [%g, %g] %-8s %s\n", name.c_str(), value,
                    row.min, row.max, row.unit, row.meaning);
      out += line;
    });
  });
  return out;
}

}  // namespace pirvs::tools
