#include "bsp/drivers/rk3399_pwm/rk3399_pwm.h"

#include <gtest/gtest.h>

#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/rk3399_pwm/rk3399_pwm_emulator.h"

namespace pirvs::bsp {
namespace {

constexpr uint32_t kClock_hz = 48'285'714;

class Rk3399PwmDriver : public testing::Test {
 protected:
  static constexpr uintptr_t kBase = 0xff42'0000;
  emulated::Rk3399PwmChip chip_{kClock_hz};
  emulated::Attachment attachment_{kBase, chip_};
  Rk3399Pwm driver_{kBase, kClock_hz};

  // A busy PC may interrupt all three tries of a start: that is kTimeout, and the caller's to
  // repeat.
  Result<TriggerStart> start(const TriggerTiming& timing) {
    for (int i = 0; i < 100; ++i) {
      const Result<TriggerStart> started = driver_.start(timing);
      if (started.status() != Status::kTimeout) return started;
      EXPECT_FALSE(chip_.enabled());
    }
    return Status::kTimeout;
  }
};

TEST_F(Rk3399PwmDriver, PulsesComeWhenTheyWereAnnounced) {
  for (const bool active_low : {false, true}) {
    const TriggerTiming timing{16'666'667, 1'000'000, 3'000'000, active_low};
    const Result<TriggerStart> started = start(timing);
    if (started.status() == Status::kTimeout) {
      GTEST_SKIP() << "this machine cannot time a start to 5 us at the moment, in 300 tries";
    }
    ASSERT_TRUE(started.ok()) << name(started.status());
    const auto [first_t, period_ns, error_ns] = started.value();
    EXPECT_EQ(error_ns, kTriggerError);
    EXPECT_NEAR(first_t, chip_.enabled_t(), kTriggerError);
    const TimeNs late = first_t % timing.period_ns - timing.phase_ns;
    EXPECT_GE(late, 0);
    EXPECT_LE(late, kTriggerError);
    EXPECT_NEAR(period_ns, 16'666'667, 11);
    const bool active = !active_low;
    for (const int k : {1, 59, 3600}) {
      const TimeNs pulse_t = first_t + static_cast<TimeNs>(k * period_ns);
      EXPECT_EQ(chip_.output(pulse_t - kTriggerError), !active) << k;
      EXPECT_EQ(chip_.output(pulse_t + kTriggerError), active) << k;
      EXPECT_EQ(chip_.output(pulse_t + 1'000'000 - kTriggerError), active) << k;
      EXPECT_EQ(chip_.output(pulse_t + 1'000'000 + kTriggerError), !active) << k;
    }
    driver_.stop();
    EXPECT_EQ(chip_.output(first_t), !active);
  }
}

TEST_F(Rk3399PwmDriver, RefusesPulsesThatAreNone) {
  const TriggerTiming good{1'000'000, 1'000, 0, false};
  TriggerTiming bad[4] = {good, good, good, good};
  bad[0].width_ns = 0;
  bad[1].width_ns = 1'000'000;
  bad[2].phase_ns = 1'000'000;
  bad[3].width_ns = 5;  // below half a tick
  for (const TriggerTiming& timing : bad) {
    EXPECT_EQ(driver_.start(timing).status(), Status::kBadData);
    EXPECT_FALSE(chip_.enabled());
  }
}

}  // namespace
}  // namespace pirvs::bsp
