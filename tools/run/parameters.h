// What    The stack's parameters by name: set, check, list.
// In      "group.name=value", or "name=value" where only one group has that name.
// Out     The changed AppParams; a table of every row for people.
// Errors  InputError: no such parameter, out of range, two groups have it.
// Source  STYLE principle 9.
#pragma once

#include <string>

#include "modules/app/app.h"

namespace pirvs::tools {

void set_parameter(AppParams& params, const std::string& assignment);

// One line per row: group.name, value, range, unit, meaning.
std::string list_parameters(const AppParams& params);

}  // namespace pirvs::tools
