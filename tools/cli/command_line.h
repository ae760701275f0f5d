// What    The command line of a run as it could be typed again, for its report.
// In      the options of a command, after they were parsed.
// Out     `pirvs NAME ...` in the order typed; a value that a shell would take apart is quoted.
// Errors  none.
// Cost    -
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace pirvs::tools {

std::string command_line(const CLI::App& command);

// A check of an option: a number that is finite and not below 0.
CLI::Validator not_negative();

}  // namespace pirvs::tools
