#include "bsp/drivers/syndrome/syndrome.h"

#include <gtest/gtest.h>

namespace pirvs::bsp {
namespace {

std::string words(uint64_t syndrome, uint64_t address, bool system_error = false) {
  Text<160> text;
  put_syndrome(text, system_error, syndrome, address);
  return text.c_str();
}

// Values as a Cortex-A72 gave them in QEMU, or put together by the manual's table.
TEST(syndrome, says_what_happened) {
  EXPECT_EQ(words(0x96000006, 0x10), "null access: read at 0x0000000000000010, not mapped");
  EXPECT_EQ(words(0x96000047, 0x40240000), "write at 0x0000000040240000, not mapped");
  EXPECT_EQ(words(0x9600004f, 0x40200000), "write at 0x0000000040200000, not allowed");
  EXPECT_EQ(words(0x96000010, 0xa000000), "read at 0x000000000a000000, nothing answers there");
  EXPECT_EQ(words(0x96000061, 0x8000001), "write at 0x0000000008000001, not aligned");
  EXPECT_EQ(words(0x96000410, 0), "read, nothing answers there");
  EXPECT_EQ(words(0x86000006, 0), "null access: jump at 0x0000000000000000, not mapped");
  EXPECT_EQ(words(0x8a000000, 0x3), "jump to an odd address 0x0000000000000003");
  EXPECT_EQ(words(0x02000000, 0), "undefined instruction");
  EXPECT_EQ(words(0xf20003e8, 0), "trap of the compiler, brk 0x3e8");
  EXPECT_EQ(words(0x1fe00000, 0), "exception of class 0x7, syndrome 0x1fe00000");
  EXPECT_EQ(words(0xbe000011, 0, true), "system error, syndrome 0xbe000011");
}

TEST(syndrome, knows_data_aborts) {
  EXPECT_TRUE(is_data_abort(0x96000047));
  EXPECT_FALSE(is_data_abort(0x86000006));
  EXPECT_FALSE(is_data_abort(0));
}

}  // namespace
}  // namespace pirvs::bsp
