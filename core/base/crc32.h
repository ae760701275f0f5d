// The checksum of files that must not be read half-written: CRC-32, as zlib and Ethernet have it.
// In      bytes, in any number of pieces. Out: value() after each.
// Errors  none. Cost: ~2.5 ns a byte, x86-64.
// Source  ISO 3309; reflected polynomial 0xEDB88320.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs {

namespace crc32 {

struct Table {
  uint32_t of[256] = {};
  constexpr Table() {
    for (uint32_t i = 0; i < 256; ++i) {
      uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit) c = (c & 1) != 0 ? 0xEDB88320u ^ c >> 1 : c >> 1;
      of[i] = c;
    }
  }
};
inline constexpr Table kTable{};

}  // namespace crc32

class Crc32 {
 public:
  void add(const void* data, size_t size) {
    const uint8_t* const bytes = static_cast<const uint8_t*>(data);
    for (size_t i = 0; i < size; ++i) {
      state_ = crc32::kTable.of[(state_ ^ bytes[i]) & 255] ^ state_ >> 8;
    }
  }
  uint32_t value() const { return ~state_; }

 private:
  uint32_t state_ = ~0u;
};

}  // namespace pirvs
