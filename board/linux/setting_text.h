// Values of the device's configuration file: a path or a name, with an end; a group of keys.
// Errors  read_text, read_key: nullptr, or what is wrong; then `out` stays.
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

template <class Settings>
struct SettingKey {
  std::string_view name;
  const char* (*read)(std::string_view, Settings&);
};

// By the key of that name; the settings are set from then on.
template <class Settings, size_t N>
const char* read_key(const SettingKey<Settings> (&keys)[N], std::string_view name,
                     std::string_view value, Settings& out) {
  for (const SettingKey<Settings>& key : keys) {
    if (key.name != name) continue;
    out.is_set = true;
    return key.read(value, out);
  }
  return "no such key";
}

}  // namespace pirvs::board
