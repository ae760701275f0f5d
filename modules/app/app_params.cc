#include "modules/app/app_params.h"

#include "core/base/number.h"

namespace pirvs {
namespace {

// The part behind "group.", the whole name where there is no dot; empty: of another group.
std::string_view name_in(std::string_view group, std::string_view name) {
  const size_t dot = name.find('.');
  if (dot == std::string_view::npos) return name;
  const std::string_view before(name.data(), dot);  // substr() may throw: not without an OS
  name.remove_prefix(dot + 1);
  return before == group ? name : std::string_view{};
}

}  // namespace

ParamAnswer set_parameter(AppParams& params, std::string_view name, float value) {
  ParamAnswer answer;
  float* field = nullptr;
  for_each_group(params, [&](const char* group, auto& values, const auto& rows) {
    const std::string_view wanted = name_in(group, name);
    for (const auto& row : rows) {
      if (wanted != row.name) continue;
      answer = {field == nullptr ? row.check(value) : ParamStatus::kAmbiguous, row.min, row.max};
      field = &(values.*row.field);
    }
  });
  if (answer.ok()) *field = value;
  return answer;
}

ParamAnswer set_parameter(AppParams& params, std::string_view name, std::string_view text) {
  double value = 0;
  if (!read_number(text, value)) return {ParamStatus::kNotANumber};
  return set_parameter(params, name, static_cast<float>(value));
}

}  // namespace pirvs
