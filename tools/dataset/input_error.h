// What    The one error a host tool throws when its input is bad: the command prints it as one line
//         on stderr and exits with 2.
// In      what is wrong, where (file, line), what to do about it.
// Errors  none of its own.
// Source  DESIGN.md, "The front door": one line, what, where, what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace pirvs::tools {

class InputError : public std::runtime_error {
 public:
  InputError(const std::string& what, const std::string& where, const std::string& what_to_do)
      : std::runtime_error(what + ": " + where + ": " + what_to_do) {}
};

}  // namespace pirvs::tools
