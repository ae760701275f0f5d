// Follows an external clock by its pulse per second: its rate against our clock, and when its
// seconds begin.
// In      add(): our time of each pulse, in order.
// Out     rate_ppb(): by how much our clock is fast; second_t(): when its last second began, by a
//         line through the last kKept pulses; noise_ns(): their rms about that line; sigma_ns():
//         how well second_t() is known by that.
// Units   ns, parts in 10^9.
// Errors  add: false: not a whole number of seconds after the last one, within kRate_ppb_max and
//         kJitter_ns: it is left out and counted, and after kOdd_max of them in a row all begins
//         anew. Which second it was, no pulse says.
// Cost    ~0.2 us a pulse.
// Source  least squares; NTP's limit for a clock's rate, 500 ppm.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/time.h"

namespace pirvs::bsp {

class Pps {
 public:
  static constexpr int kKept = 32;
  static constexpr double kRate_ppb_max = 500e3;
  static constexpr TimeNs kJitter_ns = 50'000;
  static constexpr int kOdd_max = 3;

  bool add(TimeNs t) {
    int64_t seconds = 0;
    if (count_ > 0) {
      const TimeNs gap = t - last().t;
      seconds = (gap + kSecond / 2) / kSecond;
      const double off = std::fabs(static_cast<double>(gap - seconds * kSecond));
      const double most = static_cast<double>(seconds) * kRate_ppb_max + kJitter_ns;
      if (seconds < 1 || off > most) return refuse(t);
    }
    odd_in_row_ = 0;
    push({count_ > 0 ? last().second + seconds : 0, t});
    fit();
    ++pulses_;
    return true;
  }

  bool known() const { return count_ >= 3; }
  double rate_ppb() const { return rate_ppb_; }
  TimeNs second_t() const { return second_t_; }
  double noise_ns() const { return noise_ns_; }
  // At the end of a line through n points: 2 / sqrt(n) of theirs.
  double sigma_ns() const { return count_ > 0 ? 2 * noise_ns_ / std::sqrt(count_) : 0; }
  uint32_t pulses() const { return pulses_; }
  uint32_t odd() const { return odd_; }

 private:
  static constexpr TimeNs kSecond = 1'000'000'000;
  struct Pulse {
    int64_t second;
    TimeNs t;
  };

  const Pulse& last() const { return kept_[(at_ + kKept - 1) % kKept]; }
  const Pulse& kept(int i) const { return kept_[(at_ + kKept - count_ + i) % kKept]; }
  void push(const Pulse& pulse) {
    kept_[at_] = pulse;
    at_ = (at_ + 1) % kKept;
    if (count_ < kKept) ++count_;
  }

  bool refuse(TimeNs t) {
    ++odd_;
    if (++odd_in_row_ < kOdd_max) return false;
    count_ = odd_in_row_ = 0;
    push({0, t});
    return false;
  }

  // t = a + (1 s + b) second, about the last pulse, in which all numbers are small.
  void fit() {
    if (count_ < 2) {
      second_t_ = last().t;
      return;
    }
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int i = 0; i < count_; ++i) {
      const double x = x_of(i), y = y_of(i);
      n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    const double offset = (sy - slope * sx) / n;
    rate_ppb_ = slope;  // ns a second
    second_t_ = last().t + static_cast<TimeNs>(std::lround(offset));
    double sum = 0;
    for (int i = 0; i < count_; ++i) {
      const double r = y_of(i) - offset - slope * x_of(i);
      sum += r * r;
    }
    noise_ns_ = std::sqrt(sum / n);
  }
  double x_of(int i) const { return static_cast<double>(kept(i).second - last().second); }
  double y_of(int i) const {
    return static_cast<double>(kept(i).t - last().t - (kept(i).second - last().second) * kSecond);
  }

  Pulse kept_[kKept] = {};
  int at_ = 0, count_ = 0, odd_in_row_ = 0;
  TimeNs second_t_ = 0;
  double rate_ppb_ = 0, noise_ns_ = 0;
  uint32_t pulses_ = 0, odd_ = 0;
};

}  // namespace pirvs::bsp
