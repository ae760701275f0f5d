// All parameters of the stack, and how to set one by its name.
// In      "group.name", or "name" where only one group has it; a value as a number or as text.
// Out     The changed AppParams. for_each_group is the only place that knows all groups.
// Errors  ParamStatus; with kOutOfRange and kNotWhole the row's range. Nothing changes then.
// Cost    Linear in the rows (about 100); not for the inside of a step.
// Source  STYLE principle 9.
#pragma once

#include <iterator>
#include <string_view>

#include "core/params/params.h"
#include "modules/door/door_params.h"
#include "modules/exposure/exposure_params.h"
#include "modules/frontend/frontend_params.h"
#include "modules/fusion/fusion_params.h"
#include "modules/health/health_params.h"
#include "modules/imu/imu_params.h"
#include "modules/mapping/mapping_params.h"
#include "modules/matching/matching_params.h"
#include "modules/matching/stereo.h"
#include "modules/standstill/standstill_params.h"
#include "modules/tracking/tracker.h"
#include "modules/tracking/tracking_params.h"

namespace pirvs {

struct AppParams {
  DoorParams door;
  ImuParams imu;
  FrontendParams frontend;
  TrackingParams tracking;
  MappingParams mapping;
  ExposureParams exposure;
  FusionParams fusion;
};

// Calls visit(group, struct, rows) for every group.
template <class Params, class Visit>
constexpr void for_each_group(Params& p, Visit&& visit) {
  visit("door", p.door, kDoorRows);
  visit("imu", p.imu, kImuRows);
  visit("frontend", p.frontend, kFrontendRows);
  visit("stereo", p.tracking.stereo, kStereoRows);
  visit("tracker", p.tracking.tracker, kTrackerRows);
  visit("filter", p.tracking.filter, kFilterRows);
  visit("matching", p.tracking.matching, kMatchingRows);
  visit("standstill", p.tracking.standstill, kStandstillRows);
  visit("wheels", p.tracking.wheels, kWheelRows);
  visit("health", p.tracking.health, kHealthRows);
  visit("mapping", p.mapping, kMappingRows);
  visit("exposure", p.exposure, kExposureRows);
  visit("fusion", p.fusion, kFusionRows);
}

constexpr size_t parameter_count() {
  size_t count = 0;
  const AppParams params;
  for_each_group(
      params, [&count](const char*, const auto&, const auto& rows) { count += std::size(rows); });
  return count;
}
static_assert(sizeof(AppParams) == parameter_count() * sizeof(float), "a group is not visited");

struct ParamAnswer {
  ParamStatus status = ParamStatus::kNotFound;
  float min = 0, max = 0;  // of the row, where there is one

  bool ok() const { return status == ParamStatus::kOk; }
};

[[nodiscard]] ParamAnswer set_parameter(AppParams& params, std::string_view name, float value);
[[nodiscard]] ParamAnswer set_parameter(AppParams& params, std::string_view name,
                                        std::string_view text);

}  // namespace pirvs
