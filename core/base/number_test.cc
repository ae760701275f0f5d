#include "core/base/number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>

namespace pirvs {
namespace {

TEST(number, reads_what_strtod_reads) {
  for (const char* text : {"0", "-0", "1", "+1", "-3.5", "0.1", ".5", "5.", "1e9", "1E-4", "1e+2",
                           "004", "123456789012345", "9.21", "0.0005", "2.5e-21", "1e22"}) {
    double value = -1;
    ASSERT_TRUE(read_number(text, value)) << text;
    EXPECT_EQ(value, std::strtod(text, nullptr)) << text;
    EXPECT_EQ(std::signbit(value), std::signbit(std::strtod(text, nullptr))) << text;
  }
}

TEST(number, refuses_what_is_none) {
  for (const char* text : {"", " 1", "1 ", "+", "-", ".", "-.", "e5", "1e", "1e+", "1e5x", "1.2.3",
                           "nan", "inf", "0x10", "1,5", "--1", "+-1", "two"}) {
    double value = 7;
    EXPECT_FALSE(read_number(text, value)) << text;
    EXPECT_EQ(value, 7) << text;
  }
}

TEST(number, goes_to_the_ends_of_the_range) {
  double value = 0;
  ASSERT_TRUE(read_number("1e400", value));
  EXPECT_EQ(value, std::numeric_limits<double>::infinity());
  ASSERT_TRUE(read_number("-1e99999999999", value));
  EXPECT_EQ(value, -std::numeric_limits<double>::infinity());
  ASSERT_TRUE(read_number("1e-400", value));
  EXPECT_EQ(value, 0);
  ASSERT_TRUE(read_number("0e99999", value));
  EXPECT_EQ(value, 0);
  ASSERT_TRUE(read_number("12345678901234567890123", value));  // more digits than it keeps
  EXPECT_NEAR(value / 12345678901234567890123.0, 1, 1e-15);
  ASSERT_TRUE(read_number("0.00000000000000000000012345678901234567890123", value));
  EXPECT_NEAR(value / 1.2345678901234567890123e-22, 1, 1e-15);
}

TEST(number, reads_every_double_back) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 50000; ++i) {
    const double wanted = std::ldexp(double(random()), int(random() % 90) - 105);
    for (const char* format : {"%.17g", "%.17e", "%.16e"}) {
      char text[40];
      std::snprintf(text, sizeof text, format, wanted);
      double value = 0;
      ASSERT_TRUE(read_number(text, value));
      ASSERT_EQ(value, wanted) << text;
    }
  }
}

TEST(number, reads_every_float_back) {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    const float wanted = std::ldexp(float(random()), int(random() % 60) - 46);
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", double(wanted));
    double value = 0;
    ASSERT_TRUE(read_number(text, value));
    ASSERT_EQ(float(value), wanted) << text;
  }
}

}  // namespace
}  // namespace pirvs
