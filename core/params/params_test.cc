#include "core/params/params.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <string>

namespace pirvs {
namespace {

struct Params {
  float speed_m_s = 2.0f;
  float tries = 3.0f;
};

constexpr ParamRow<Params> kRows[] = {
    {"speed_m_s", &Params::speed_m_s, 0.5f, 4.0f, "m/s", Audience::kUser, "how fast"},
    {"tries", &Params::tries, 1, 10, count_of("tries"), Audience::kExpert, "how often"},
};
static_assert(sizeof(Params) == std::size(kRows) * sizeof(float));
static_assert(in_range(Params{}, kRows));
static_assert(!in_range(Params{5.0f, 3.0f}, kRows));
static_assert(!in_range(Params{2.0f, 3.5f}, kRows));

TEST(Params, SetsByNameWithinTheRange) {
  Params params;
  EXPECT_EQ(set_param(params, kRows, "speed_m_s", 4.0f), ParamStatus::kOk);
  EXPECT_EQ(params.speed_m_s, 4.0f);
  EXPECT_EQ(set_param(params, kRows, "speed_m_s", 4.1f), ParamStatus::kOutOfRange);
  EXPECT_EQ(set_param(params, kRows, "speed_m_s", NAN), ParamStatus::kOutOfRange);
  EXPECT_EQ(set_param(params, kRows, "speed", 1.0f), ParamStatus::kNotFound);
  EXPECT_EQ(params.speed_m_s, 4.0f);
  EXPECT_EQ(params.tries, 3.0f);
}

TEST(Params, TakesNoFractionOfACount) {
  Params params;
  EXPECT_EQ(set_param(params, kRows, "tries", 3.9f), ParamStatus::kNotWhole);
  EXPECT_EQ(params.tries, 3.0f);
  EXPECT_EQ(set_param(params, kRows, "tries", 10.5f), ParamStatus::kOutOfRange);
  EXPECT_EQ(set_param(params, kRows, "tries", 1e30f), ParamStatus::kOutOfRange);
  EXPECT_EQ(set_param(params, kRows, "tries", 4.0f), ParamStatus::kOk);
  EXPECT_EQ(params.tries, 4.0f);
}

TEST(Params, VisitsEveryRow) {
  std::string text;
  for_each_param(Params{}, kRows, [&text](const ParamRow<Params>& row, float value) {
    text +=
        std::string(row.name) + "=" + std::to_string(static_cast<int>(value)) + row.unit.name + ";";
  });
  EXPECT_EQ(text, "speed_m_s=2m/s;tries=3tries;");
}

}  // namespace
}  // namespace pirvs
