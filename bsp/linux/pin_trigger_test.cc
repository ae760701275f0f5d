#include "bsp/linux/pin_trigger.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "bsp/api/clock.h"
#include "bsp/linux/clock.h"

namespace pirvs::bsp {
namespace {

constexpr TimeNs kMs = 1'000'000, kPeriod = 50 * kMs;

PulsePlan grid() {
  PulsePlan plan;
  plan.first_t = 1000 * kPeriod;
  plan.period_ns = kPeriod;
  plan.until_t = INT64_MAX;
  return plan;
}

TEST(pin_trigger, begins_half_an_exposure_before_the_point_of_each_image) {
  TimeNs exposure[PinTrigger::kAhead];
  std::fill(exposure, exposure + PinTrigger::kAhead, 20 * kMs);
  exposure[0] = 4 * kMs;  // the next image has the old one
  for (const TimeNs off : {-20 * kMs, TimeNs{0}, 20 * kMs}) {
    const TimeNs frame = 1007 * kPeriod;
    const PulsePlan plan = centred(grid(), frame + off, exposure);
    EXPECT_EQ(plan.first_t, frame) << "the nearest point, always of the grid";
    EXPECT_EQ(plan.begin_of(frame + kPeriod), frame + kPeriod - 2 * kMs);
    for (int k = 2; k < 20; ++k) {
      EXPECT_EQ(plan.begin_of(frame + k * kPeriod), frame + k * kPeriod - 10 * kMs);
    }
  }
  // A frame that was triggered by another before.
  EXPECT_EQ(centred(grid(), 990 * kPeriod - kMs, exposure).first_t, 990 * kPeriod);
  EXPECT_EQ(next_pulse(centred(grid(), 990 * kPeriod, exposure), 993 * kPeriod - 1), 993 * kPeriod);
}

TEST(pin_trigger, what_cannot_be_is_refused) {
  PinTrigger trigger;
  trigger.configure("gpiochip250:1", false);
  EXPECT_EQ(trigger.start({20'000'000, 0, 0, false}).status(), Status::kBadData);
  EXPECT_EQ(trigger.start({20'000'000, 10'000'001, 0, false}).status(), Status::kBadData);
  EXPECT_EQ(trigger.start({20'000'000, 1'000'000, 20'000'000, false}).status(), Status::kBadData);
  EXPECT_EQ(trigger.start({20'000'000, 1'000'000, 0, true}).status(), Status::kBadData);
  EXPECT_EQ(trigger.start({20'000'000, 1'000'000, 0, false}).status(), Status::kBusFault);
  EXPECT_NE(std::strstr(trigger.why(), "no such pin"), nullptr);
  EXPECT_FALSE(trigger.runs());
  EXPECT_EQ(trigger.stop(), Status::kOk);
}

// However busy this machine is: each point is a pulse, or is counted as left out.
TEST(pulse_thread, passes_no_point_over_without_a_count) {
  constexpr TimeNs kShort = 4 * kMs;
  OutputPin nothing;  // its level goes nowhere
  PulseThread thread;
  PulsePlan plan;
  plan.first_t = now() + 20 * kMs;
  plan.period_ns = kShort;
  plan.until_t = plan.first_t + 49 * kShort;
  plan.counted = true;
  std::fill(std::begin(plan.lead_ns), std::end(plan.lead_ns), kMs);
  thread.plan(plan);
  ASSERT_EQ(thread.start(nothing, kMs / 2, false), Status::kOk);
  sleep_until(plan.first_t + 20 * kShort + kShort / 2);
  for (TimeNs& lead : plan.lead_ns) lead = kMs / 2;  // a new exposure: the grid stays
  thread.plan(plan);
  sleep_until(plan.until_t + 100 * kMs);
  thread.stop();
  const uint32_t points = thread.pulses() + thread.left_out();
  EXPECT_LE(points, 50u);
  EXPECT_GE(points, 49u) << "the last one may pass unseen";
  EXPECT_GT(thread.pulses(), 0u);
}

}  // namespace
}  // namespace pirvs::bsp
