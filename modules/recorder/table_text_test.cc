#include "modules/recorder/table_text.h"

#include <gtest/gtest.h>

#include <cfloat>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

namespace pirvs {
namespace {

std::string text_of(double value) {
  TableText text;
  text.add(value);
  return {text.data(), text.size()};
}

bool reads_back(double value) {
  const double read = std::strtod(text_of(value).c_str(), nullptr);
  return std::memcmp(&read, &value, sizeof value) == 0;
}

TEST(recorder_text, short_numbers_stay_short) {
  EXPECT_EQ(text_of(0), "0");
  EXPECT_EQ(text_of(-0.0), "-0");
  EXPECT_EQ(text_of(0.1), "0.1");
  EXPECT_EQ(text_of(-9.81), "-9.81");
  EXPECT_EQ(text_of(-0.0837758041), "-0.0837758041");
  EXPECT_EQ(text_of(200), "200");
  EXPECT_EQ(text_of(NAN), "nan");
  EXPECT_EQ(text_of(-INFINITY), "-inf");
}

TEST(recorder_text, every_double_reads_back_to_the_bit) {
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
    if (std::isfinite(any)) ASSERT_TRUE(reads_back(any)) << any;
    const double usual = std::uniform_real_distribution<double>(-40, 40)(random);
    ASSERT_TRUE(reads_back(usual)) << usual;
    ASSERT_TRUE(reads_back(std::round(usual * 1e6) / 1e6)) << usual;
  }
}

TEST(recorder_text, a_number_keeps_within_its_room) {
  for (const double value : {-DBL_MAX, -DBL_TRUE_MIN, -1.0 / 3, -899999.1234567891}) {
    EXPECT_LE(text_of(value).size(), TableText::kNumber);
  }
  TableText text;
  text.add(int64_t{INT64_MIN}).add(",").add(int64_t{INT64_MAX});
  EXPECT_EQ(std::string(text.data(), text.size()), "-9223372036854775808,9223372036854775807");
}

}  // namespace
}  // namespace pirvs
