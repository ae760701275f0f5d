// For tests: what a receiver says.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

namespace pirvs::testing {

// NMEA 0183: `body` between $ and *, with its checksum.
inline std::string sentence(const std::string& body) {
  uint8_t sum = 0;
  for (const char c : body) sum = uint8_t(sum ^ uint8_t(c));
  char tail[8];
  std::snprintf(tail, sizeof tail, "*%02X\r\n", sum);
  return "$" + body + tail;
}

}  // namespace pirvs::testing
