// A path or a name of the device's configuration file, with an end.
// Errors  read_text: nullptr, or what is wrong; then `out` stays.
#pragma once

#include <cstring>
#include <string_view>

namespace pirvs::board {

struct SettingText {
  char text[96] = "";
};

inline const char* read_text(std::string_view value, SettingText& out) {
  if (value.size() >= sizeof out.text) return "longer than 95 bytes";
  std::memcpy(out.text, value.data(), value.size());
  out.text[value.size()] = 0;
  return nullptr;
}

}  // namespace pirvs::board
