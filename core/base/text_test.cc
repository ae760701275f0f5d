#include "core/base/text.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

namespace pirvs {
namespace {

std::string fixed(double value, int decimals) {
  Text<64> text;
  text.fixed(value, decimals);
  return text.c_str();
}

std::string printed(double value, int decimals) {
  char text[400];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

TEST(text, fixed_writes_what_printf_writes) {
  std::mt19937_64 random(1);
  const double scales[] = {1e-320, 1e-12, 1e-9, 1e-3, 1.0, 1e3, 1e9, 1e17};
  for (int i = 0; i < 20000; ++i) {
    const double unit = std::ldexp(static_cast<double>(random() >> 11), -52) - 1.0;
    const double value = unit * scales[i % std::size(scales)];
    ASSERT_EQ(fixed(value, i % 10), printed(value, i % 10)) << value << " " << i % 10;
  }
}

TEST(text, fixed_rounds_exact_halves_to_even) {
  for (const double value : {0.5, 1.5, 2.5, -0.5, 0.125, 0.375, 1e-9, 5e-10, 0.0, -0.0, 9.5,
                             999999999.9999999, 1.0 / 3.0, 4503599627370497.5, 5e-324}) {
    for (int decimals = 0; decimals <= 9; ++decimals) {
      EXPECT_EQ(fixed(value, decimals), printed(value, decimals)) << value << " " << decimals;
    }
  }
  EXPECT_EQ(fixed(NAN, 3), "nan");
  EXPECT_EQ(fixed(-INFINITY, 3), "nan");
  EXPECT_EQ(fixed(1e18, 0), "nan");
}

std::string exact(double value) {
  Text<64> text;
  text.exact(value);
  return text.c_str();
}

bool reads_back(double value) {
  const double read = std::strtod(exact(value).c_str(), nullptr);
  return std::memcmp(&read, &value, sizeof value) == 0;
}

TEST(text, exact_keeps_short_numbers_short) {
  EXPECT_EQ(exact(0), "0");
  EXPECT_EQ(exact(-0.0), "-0");
  EXPECT_EQ(exact(0.1), "0.1");
  EXPECT_EQ(exact(-9.81), "-9.81");
  EXPECT_EQ(exact(-0.0837758041), "-0.0837758041");
  EXPECT_EQ(exact(200), "200");
  EXPECT_EQ(exact(NAN), "nan");
  EXPECT_EQ(exact(-INFINITY), "-inf");
}

TEST(text, every_exact_double_reads_back_to_the_bit) {
  for (const double value : {DBL_MAX, DBL_MIN, DBL_TRUE_MIN, DBL_EPSILON, 1e300, 1e-300, 1.0 / 3,
                             2.0 / 3, 9e5, 9.0000001e5, 1e15, 123456.7890123456789, 1e10, 5e-324}) {
    EXPECT_TRUE(reads_back(value)) << value;
    EXPECT_TRUE(reads_back(-value)) << value;
  }
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    const uint64_t bits = random();
    double any;
    std::memcpy(&any, &bits, sizeof any);
    ASSERT_TRUE(!std::isfinite(any) || reads_back(any)) << any;
    const double usual = std::uniform_real_distribution<double>(-40, 40)(random);
    ASSERT_TRUE(reads_back(usual)) << usual;
    ASSERT_TRUE(reads_back(std::round(usual * 1e6) / 1e6)) << usual;
  }
}

TEST(text, an_exact_double_keeps_within_its_room) {
  for (const double value : {-DBL_MAX, -DBL_TRUE_MIN, -1.0 / 3, -899999.1234567891}) {
    EXPECT_LE(exact(value).size(), TextWriter::kNumber);
  }
}

TEST(text, writes_integers) {
  Text<128> text;
  text.number(INT64_MIN).put(' ').number(-7).put(' ').number(0).put(' ').unsigned_number(
      UINT64_MAX);
  EXPECT_STREQ(text.c_str(), "-9223372036854775808 -7 0 18446744073709551615");
  text.clear();
  text.unsigned_number(42, 9).put(' ').hex(0).put(' ').hex(0x12, 8).put(' ').hex(UINT64_MAX);
  EXPECT_STREQ(text.c_str(), "000000042 0x0 0x00000012 0xffffffffffffffff");
}

TEST(text, leaves_out_what_does_not_fit_and_says_so) {
  Text<8> text;
  text.put("1234567");
  EXPECT_FALSE(text.full());
  text.put("89");
  EXPECT_TRUE(text.full());
  EXPECT_STREQ(text.c_str(), "1234567");
  text.clear();
  EXPECT_EQ(text.size(), 0u);
  EXPECT_FALSE(text.full());
}

}  // namespace
}  // namespace pirvs
