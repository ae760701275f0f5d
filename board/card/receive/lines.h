// What goes between `pirvs update` and a device, and what RAUC says of its work: lines of text.
// In      A line without its end.
// Out     parse_request: what a PC asks for:
//           pirvs 1 version              answer: version V slot a good | trial LEFT boot ID
//           pirvs 1 update BYTES         answer: ready; then the bundle; then lines of
//                                        progress PERCENT TEXT, and at last installed, or
//                                        refused WHY, which may come at any time
//         parse_rauc: a line of `rauc install`.
// Errors  kind kNone: none of these.
// Cost    microseconds.
// Source  docs/device.md; RAUC 1.8, src/main.c, on_installer_changed.
#pragma once

#include <cstdint>
#include <string_view>

namespace pirvs::card {

inline constexpr uint64_t kBundleBytesMax = 512ull << 20;

struct Request {
  enum class Kind : uint8_t { kNone, kVersion, kUpdate } kind = Kind::kNone;
  uint64_t bytes = 0;
};
Request parse_request(std::string_view line);

struct RaucLine {
  enum class Kind : uint8_t { kNone, kProgress, kError } kind = Kind::kNone;
  int percent = 0;
  std::string_view text;
};
RaucLine parse_rauc(std::string_view line);

// The rest of the line that begins with `key`, without quotes: of /etc/os-release.
std::string_view find_value(std::string_view text, std::string_view key);
// The value of a word key=value.
std::string_view find_word(std::string_view text, std::string_view key);

}  // namespace pirvs::card
