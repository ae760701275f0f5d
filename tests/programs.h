// The programs that make has built, run by the shell.
// In      PIRVS_BUILD: make's folder (default build).
// Errors  said_by: fails the test unless the command ends with exit status 0.
#pragma once

#include <string>

namespace pirvs::systems {

std::string build_folder();
// What a command of the shell prints on standard output.
std::string said_by(const std::string& command);

}  // namespace pirvs::systems
