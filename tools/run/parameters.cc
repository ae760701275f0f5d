#include "tools/run/parameters.h"

#include <cstdio>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {

void set_parameter(AppParams& params, const std::string& assignment) {
  const size_t equals = assignment.find('=');
  if (equals == std::string::npos) {
    throw InputError("not a parameter and a number", "--set " + assignment, "use name=value");
  }
  const ParamAnswer answer =
      set_parameter(params, assignment.substr(0, equals), assignment.substr(equals + 1));
  std::string hint;
  char range[96];
  std::snprintf(range, sizeof range, "choose %g to %g", answer.min, answer.max);
  switch (answer.status) {
    case ParamStatus::kOk:
      return;
    case ParamStatus::kNotFound:
      hint = "pirvs params --all lists them";
      break;
    case ParamStatus::kAmbiguous:
      hint = "write group.name=value";
      break;
    case ParamStatus::kNotANumber:
      hint = "use name=value";
      break;
    case ParamStatus::kOutOfRange:
      hint = range;
      break;
    case ParamStatus::kNotWhole:
      hint = std::string("it is a count: ") + range;
      break;
  }
  throw InputError(name(answer.status), "--set " + assignment, hint);
}

std::string list_parameters(const AppParams& params, bool all) {
  std::string out;
  int hidden = 0;
  for_each_group(params, [&](const char* group, const auto& values, const auto& rows) {
    for_each_param(values, rows, [&](const auto& row, float value) {
      const bool expert = row.audience == Audience::kExpert;
      if (expert && !all) {
        ++hidden;
        return;
      }
      const std::string name = std::string(group) + "." + row.name;
      char range[48], line[384];
      std::snprintf(range, sizeof range, "[%g, %g]", row.min, row.max);
      std::snprintf(line, sizeof line, "%-36s %8g  %-15s %-10s %s%s\n", name.c_str(), value, range,
                    row.unit.name, expert ? "(expert) " : "", row.meaning);
      out += line;
    });
  });
  if (hidden > 0) {
    out += std::to_string(hidden) + " more for experts: pirvs params --all\n";
  }
  return out;
}

}  // namespace pirvs::tools
