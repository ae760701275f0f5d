#include "bsp/drivers/pps/pps.h"

#include <gtest/gtest.h>

namespace pirvs::bsp {
namespace {

constexpr TimeNs kSecond = 1'000'000'000;

TEST(pps, finds_rate_and_second_through_jitter_and_missing_pulses) {
  Pps pps;
  constexpr double kFast_ppb = 23'000;
  TimeNs truth = 0;
  uint32_t random = 1;
  for (int k = 0; k < 100; ++k) {
    truth = 7 * kSecond + 123'456'789 + static_cast<TimeNs>(k * (1e9 + kFast_ppb));
    random = random * 1664525 + 1013904223;
    if (k % 7 == 3) continue;
    EXPECT_TRUE(pps.add(truth + random % 4'000));
  }
  EXPECT_TRUE(pps.known());
  EXPECT_NEAR(pps.rate_ppb(), kFast_ppb, 60);
  EXPECT_NEAR(static_cast<double>(pps.second_t() - truth), 2'000, 1'500);
  EXPECT_NEAR(pps.noise_ns(), 1'150, 400);
}

TEST(pps, leaves_out_what_is_no_second_and_begins_anew_after_three) {
  Pps pps;
  for (int k = 0; k < 10; ++k) EXPECT_TRUE(pps.add(k * kSecond));
  EXPECT_FALSE(pps.add(9 * kSecond + kSecond / 3));
  EXPECT_TRUE(pps.add(10 * kSecond));
  EXPECT_EQ(pps.odd(), 1u);
  EXPECT_NEAR(pps.rate_ppb(), 0, 1e-3);
  const TimeNs moved = kSecond / 2;  // the external clock was set
  for (int k = 11; k < 14; ++k) EXPECT_FALSE(pps.add(k * kSecond + moved));
  for (int k = 14; k < 18; ++k) EXPECT_TRUE(pps.add(k * kSecond + moved));
  EXPECT_EQ(pps.second_t(), 17 * kSecond + moved);
}

}  // namespace
}  // namespace pirvs::bsp
