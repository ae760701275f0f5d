#include "board/linux/exposure_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace pirvs::board {
namespace {

constexpr TimeNs kPeriod = 16'666'667, kMicro = 1'000;

TimeNs next_after(const ExposureClock& clock, TimeNs t) { return bsp::next_pulse(clock.plan(), t); }

TEST(exposure_clock, foretells_the_next_exposures) {
  ExposureClock clock;
  uint32_t random = 1;
  TimeNs worst = 0;
  for (int k = 0; k < 600; ++k) {
    random = random * 1664525 + 1013904223;
    const TimeNs jitter = static_cast<TimeNs>(random >> 8) % (20 * kMicro) - 10 * kMicro;
    if (k % 13 != 5 || k == 1) clock.add(1000 + k * kPeriod + jitter);
    if (k < 20) continue;
    const TimeNs wanted = 1000 + (k + 2) * kPeriod;
    worst = std::max(worst, std::abs(next_after(clock, wanted - kPeriod / 2) - wanted));
  }
  EXPECT_LT(worst, 30 * kMicro);
}

TEST(exposure_clock, says_nothing_before_three_frames_and_after_the_last) {
  ExposureClock clock;
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(next_after(clock, k * kPeriod), INT64_MAX);
    clock.add(k * kPeriod);
  }
  EXPECT_NE(next_after(clock, 3 * kPeriod), INT64_MAX);
  EXPECT_EQ(next_after(clock, (3 + ExposureClock::kAhead) * kPeriod), INT64_MAX);
}

TEST(exposure_clock, learns_anew_when_the_rhythm_changes) {
  ExposureClock clock;
  for (int k = 0; k < 10; ++k) clock.add(k * kPeriod);
  TimeNs t = 9 * kPeriod + kPeriod / 2;
  clock.add(t);
  EXPECT_EQ(next_after(clock, t), INT64_MAX);
  for (int k = 0; k < 9; ++k) clock.add(t += 2 * kPeriod);
  EXPECT_NEAR(double(next_after(clock, t + kPeriod)), double(t + 2 * kPeriod), 1.0);
}

TEST(exposure_clock, a_first_interval_with_a_frame_missing_is_no_period) {
  ExposureClock clock;
  for (const int k : {0, 2, 3, 4, 5, 6, 7}) clock.add(k * kPeriod);
  EXPECT_NEAR(double(next_after(clock, 7 * kPeriod + 1)), 8.0 * kPeriod, 1.0);
}

}  // namespace
}  // namespace pirvs::board
