// Against the C library, over sizes, misalignments and overlaps. The address sanitizer sees what is
// read or written outside.
#include "core/base/bytes.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace pirvs {
namespace {

constexpr size_t kSizeMax = 300;  // four blocks and more
constexpr size_t kShiftMax = 17;

std::vector<uint8_t> numbered(size_t size) {
  std::vector<uint8_t> bytes(size);
  for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<uint8_t>(i * 7 + i / 251);
  return bytes;
}

TEST(bytes, fill_what_they_should_and_nothing_else) {
  for (const uint8_t value : {uint8_t{0}, uint8_t{0xa5}}) {
    for (size_t size = 0; size <= kSizeMax; ++size) {
      for (size_t shift = 0; shift < kShiftMax; ++shift) {
        std::vector<uint8_t> got = numbered(size + 2 * kShiftMax), wanted = got;
        fill_bytes(got.data() + shift, value, size);
        std::memset(wanted.data() + shift, value, size);
        ASSERT_EQ(got, wanted) << size << " bytes at " << shift;
      }
    }
  }
}

TEST(bytes, touch_nothing_outside_a_block_of_their_size) {
  for (size_t size = 1; size <= kSizeMax; ++size) {
    const std::vector<uint8_t> from = numbered(size);
    std::vector<uint8_t> to(size);  // the sanitizer guards both its ends
    move_bytes(to.data(), from.data(), size);
    ASSERT_EQ(to, from);
    fill_bytes(to.data(), 3, size);
    ASSERT_EQ(to, std::vector<uint8_t>(size, 3));
  }
}

TEST(bytes, move_between_any_addresses_and_over_themselves) {
  for (size_t size = 0; size <= kSizeMax; ++size) {
    for (size_t to = 0; to < 2 * kSizeMax; to += to < kSizeMax + 80 ? 1 : 37) {
      std::vector<uint8_t> got = numbered(3 * kSizeMax), wanted = got;
      move_bytes(got.data() + to, got.data() + kSizeMax, size);
      std::memmove(wanted.data() + to, wanted.data() + kSizeMax, size);
      ASSERT_EQ(got, wanted) << size << " bytes by " << to;
    }
  }
}

}  // namespace
}  // namespace pirvs
