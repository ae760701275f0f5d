// A name that is the same to a shell, a file system and a line of text: letters, digits and . _ -.
// Errors  none. Cost: its length.
// Source  own.
#pragma once

#include <string_view>

namespace pirvs {

inline bool is_plain_name(std::string_view name) {
  for (const char c : name) {
    const bool good = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                      c == '.' || c == '_' || c == '-';
    if (!good) return false;
  }
  return !name.empty();
}

}  // namespace pirvs
