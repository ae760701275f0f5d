// What    The stack's parameters on the command line: --set and `pirvs params`.
// In      "group.name=value", or "name=value" where only one group has that name.
// Out     The changed AppParams; a table of rows for people.
// Errors  InputError: no such parameter, out of range, not a whole number, two groups have it.
// Source  STYLE principle 9; modules/app/app_params.h.
#pragma once

#include <string>

#include "modules/app/app_params.h"

namespace pirvs::tools {

void set_parameter(AppParams& params, const std::string& assignment);

// One line per row: group.name, value, range, unit, meaning. Those for users, or all of them with
// the experts' marked.
std::string list_parameters(const AppParams& params, bool all);

}  // namespace pirvs::tools
