#include "modules/gnss/receiver_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "modules/testing.h"

namespace pirvs {
namespace {

constexpr TimeNs kSecond = 1'000'000'000, kMilli = 1'000'000;
constexpr TimeNs kUtc = 1'700'000'000 * kSecond;  // of the first fix

// A device whose clock is fast, and a receiver that tells its fixes late.
class Receiver {
 public:
  explicit Receiver(double rate_ppb) : rate_ppb_(rate_ppb) {}
  TimeNs ours(TimeNs t_own) const {
    const TimeNs since = t_own - kUtc;
    return 77 * kSecond + 123'456'789 + since +
           TimeNs(std::llround(rate_ppb_ * 1e-9 * double(since)));
  }
  // At least 60 ms, mostly a little more, now and then much more.
  TimeNs latency() {
    const double more_s = -0.008 * std::log(1 - random_.uniform(0, 0.999));
    return 60 * kMilli + from_seconds(more_s) + (random_.uniform(0, 1) < 0.05 ? 200 * kMilli : 0);
  }
  ReceiverSecond second(TimeNs t_own) {
    return {ours(t_own) + TimeNs(random_.gauss(700)), rate_ppb_ + random_.gauss(20), 700};
  }

 private:
  double rate_ppb_;
  testing::Random random_{5};
};

TEST(receiver_clock, the_least_latency_counts_and_two_clocks_may_part) {
  for (const double rate_ppb : {-60e3, 0.0, 60e3}) {
    Receiver receiver(rate_ppb);
    ReceiverClock clock;
    clock.configure(80 * kMilli);
    double worst_ms = 0;
    for (int k = 0; k < 3000; ++k) {
      const TimeNs own = kUtc + k * kSecond / 5, truth = receiver.ours(own);
      ReceiverStamp stamp;
      ASSERT_EQ(clock.stamp(own, truth + receiver.latency(), stamp), Status::kOk);
      EXPECT_FALSE(stamp.by_pulse);
      EXPECT_EQ(stamp.sigma_ns, 40e6);
      // It takes the latency for 80 ms; the least is 60.
      const double off_ms = 1e-6 * double(stamp.t - truth) + 20;
      if (k > 50) worst_ms = std::max(worst_ms, std::fabs(off_ms));
    }
    EXPECT_LT(worst_ms, 10) << rate_ppb;
  }
}

TEST(receiver_clock, pulses_tell_the_time_whatever_the_latency) {
  for (const TimeNs more : {TimeNs{0}, 400 * kMilli, 600 * kMilli}) {
    Receiver receiver(-23e3);
    ReceiverClock clock;
    clock.configure(80 * kMilli);
    for (int k = 0; k < 1000; ++k) {
      const TimeNs own = kUtc + k * kSecond / 5 - 300'000, truth = receiver.ours(own);
      if (k % 5 == 0) clock.pulse(receiver.second(kUtc + k * kSecond / 5));
      ReceiverStamp stamp;
      ASSERT_EQ(clock.stamp(own, truth + more + receiver.latency(), stamp), Status::kOk);
      ASSERT_TRUE(stamp.by_pulse);
      EXPECT_NEAR(double(stamp.t - truth), 0, 5'000) << k;
      EXPECT_NEAR(stamp.sigma_ns, 5'050, 100);
    }
  }
}

TEST(receiver_clock, pulses_that_stop_are_believed_for_a_while) {
  Receiver receiver(0);
  ReceiverClock clock;
  clock.configure(80 * kMilli);
  clock.pulse(receiver.second(kUtc));
  ReceiverStamp stamp;
  for (int k = 1; k <= 60; ++k) {
    const TimeNs own = kUtc + k * kSecond;
    ASSERT_EQ(clock.stamp(own, receiver.ours(own) + 60 * kMilli, stamp), Status::kOk);
    EXPECT_EQ(stamp.by_pulse, k <= 30) << k;
  }
  EXPECT_EQ(stamp.sigma_ns, 40e6);
}

TEST(receiver_clock, a_time_that_does_not_go_on_is_refused_until_it_is_told_again) {
  Receiver receiver(0);
  for (const TimeNs step : {-18 * kSecond, 3600 * kSecond}) {
    ReceiverClock clock;
    clock.configure(80 * kMilli);
    ReceiverStamp stamp;
    const auto tell = [&](int k, TimeNs wrong) {
      const TimeNs own = kUtc + k * kSecond;
      return clock.stamp(own + wrong, receiver.ours(own) + 60 * kMilli, stamp);
    };
    for (int k = 0; k < 10; ++k) EXPECT_EQ(tell(k, 0), Status::kOk);
    EXPECT_EQ(tell(10, step), Status::kBadData) << "one damaged date";
    for (int k = 11; k < 20; ++k) EXPECT_EQ(tell(k, 0), Status::kOk);
    EXPECT_EQ(tell(20, step), Status::kBadData);
    EXPECT_EQ(tell(21, step), Status::kBadData);
    EXPECT_EQ(tell(22, step), Status::kOk) << "the receiver has set its clock";
    EXPECT_NEAR(double(stamp.t - receiver.ours(kUtc + 22 * kSecond)), -20e6, 1e6);
  }
}

TEST(receiver_clock, a_fix_that_came_long_ago_says_nothing_of_the_clock) {
  Receiver receiver(0);
  ReceiverClock clock;
  clock.configure(60 * kMilli);
  ReceiverStamp stamp;
  EXPECT_EQ(clock.stamp(kUtc, stamp), Status::kEmpty);
  const TimeNs own = kUtc + kSecond, truth = receiver.ours(own);
  ASSERT_EQ(clock.stamp(own, truth + 60 * kMilli, stamp), Status::kOk);
  EXPECT_EQ(stamp.t, truth);
  ASSERT_EQ(clock.stamp(kUtc, stamp), Status::kOk);
  EXPECT_EQ(stamp.t, receiver.ours(kUtc));
}

TEST(receiver_clock, without_a_time_the_arrival_counts) {
  ReceiverClock clock;
  clock.configure(50 * kMilli);
  const ReceiverStamp stamp = clock.stamp_without_time(7 * kSecond);
  EXPECT_EQ(stamp.t, 7 * kSecond - 50 * kMilli);
  EXPECT_EQ(stamp.sigma_ns, 50e6);
}

}  // namespace
}  // namespace pirvs
