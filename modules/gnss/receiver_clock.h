// When a fix was measured, on the device's clock: by the receiver's pulse per second, or by how its
// fixes come in.
// In      pulse(): where a second of the receiver began, as the line through its pulses says
//         (bsp/drivers/pps/pps.h). stamp(): the receiver's own time of a fix, and when it came.
// Out     The fix's time and the sigma of it.
//         By pulses: they say when seconds begin, not which; the fixes' arrivals say that, since
//         each comes kLatestAfter_ns at most behind its own second.
//         Without: of arrival minus own time the least counts, since a message may be delayed and
//         never comes early; it rises by kDrift, lest two clocks that part are held together. What
//         the least latency itself is cannot be seen: `latency_ns` is taken for it, within half of
//         that.
// Units   ns; own time: since 1970.
// Errors  kBadData: own time and arrival do not go together as they did (the receiver set its
//         clock, a damaged date, a long stall). After kOddMax in a row all begins anew.
// Cost    ~20 ns.
// Source  Cristian's algorithm, one way (Distributed Computing, 1989); docs/gnss.md, "Stamps".
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/status.h"
#include "core/base/time.h"

namespace pirvs {

struct ReceiverSecond {
  TimeNs t = 0;         // when one began
  double rate_ppb = 0;  // by how much the device's clock is fast
  double sigma_ns = 0;  // of t
};

struct ReceiverStamp {
  TimeNs t = 0;
  double sigma_ns = 0;
  bool by_pulse = false;
};

class ReceiverClock {
 public:
  static constexpr TimeNs kLatency_ns = 80'000'000;  // of usual receivers, 30 to 150 ms
  static constexpr TimeNs kOdd_ns = 500'000'000;
  static constexpr int kOddMax = 3;

  void configure(TimeNs latency_ns) {
    *this = ReceiverClock{};
    latency_ns_ = latency_ns;
  }

  void pulse(const ReceiverSecond& second) {
    second_ = second;
    has_second_ = true;
  }

  Status stamp(TimeNs t_own, TimeNs arrival, ReceiverStamp& out) {
    if (!follow(arrival - t_own, arrival)) return Status::kBadData;
    return stamp(t_own, out);
  }

  // Of a fix of which nobody knows when it came. kEmpty: nor is the receiver's clock known yet.
  Status stamp(TimeNs t_own, ReceiverStamp& out) const {
    if (!known_) return Status::kEmpty;
    const TimeNs least = t_own + least_ns_;  // when it comes with the least latency
    out = {least - latency_ns_, 0.5 * static_cast<double>(latency_ns_), false};
    if (has_second_) stamp_by_pulse(t_own, least, out);
    return Status::kOk;
  }

  // Of a fix whose receiver does not know the time.
  ReceiverStamp stamp_without_time(TimeNs arrival) const {
    return {arrival - latency_ns_, static_cast<double>(latency_ns_), false};
  }

 private:
  static constexpr double kDrift = 100e-6;                // of two quartzes
  static constexpr TimeNs kLatestAfter_ns = 900'000'000;  // in which a fix reaches us
  static constexpr TimeNs kSecond_ns = 1'000'000'000;
  static constexpr TimeNs kPulseOld_ns = 30 * kSecond_ns;
  static constexpr double kRate_ppb = 100;   // how far the rate may change meanwhile
  static constexpr double kEdge_ns = 5'000;  // an interrupt's latency, which a line cannot see

  bool follow(TimeNs delay, TimeNs arrival) {
    const TimeNs risen =
        least_ns_ + static_cast<TimeNs>(kDrift * static_cast<double>(arrival - arrival_));
    const bool odd = known_ && (delay > risen + kOdd_ns || delay < risen - kOdd_ns);
    const bool again = odd && ++odd_in_row_ < kOddMax;
    if (again) return false;
    if (odd || !known_ || delay < risen) {
      least_ns_ = delay;
    } else {
      least_ns_ = risen;
    }
    known_ = true;
    odd_in_row_ = 0;
    arrival_ = arrival;
    return true;
  }

  // The pulse that began the fix's own second came before it did, by kLatestAfter_ns at most.
  void stamp_by_pulse(TimeNs t_own, TimeNs least, ReceiverStamp& out) const {
    const TimeNs part = t_own % kSecond_ns;
    const double period = static_cast<double>(kSecond_ns) + second_.rate_ppb;
    const double from = static_cast<double>(least - part - second_.t);
    const double k =
        std::floor((from + static_cast<double>(kSecond_ns - kLatestAfter_ns)) / period);
    const double after = k * period + static_cast<double>(part) * (period / 1e9);
    if (std::fabs(after) > static_cast<double>(kPulseOld_ns)) return;
    const double held_ns = kRate_ppb * std::fabs(after) / 1e9;
    out.t = second_.t + static_cast<TimeNs>(std::llround(after));
    out.sigma_ns =
        std::sqrt(second_.sigma_ns * second_.sigma_ns + held_ns * held_ns + kEdge_ns * kEdge_ns);
    out.by_pulse = true;
  }

  TimeNs latency_ns_ = kLatency_ns;
  bool known_ = false;
  TimeNs least_ns_ = 0;  // of arrival minus own time, as of arrival_
  TimeNs arrival_ = 0;
  int odd_in_row_ = 0;
  bool has_second_ = false;
  ReceiverSecond second_;
};

}  // namespace pirvs
