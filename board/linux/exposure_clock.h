// Predicts the mid-exposure times of the next frames from the stamps of past frames.
// In      add(): each frame's t, in order; frames may be missing.
// Out     plan(): pulses at the middle of the exposures to come, for as long as kAhead periods
//         after the last frame. Empty until three frames agree on a period.
// Units   ns.
// Errors  A stamp that is off by more than a quarter of a period: all is learnt anew.
// Cost    ~10 ns.
// Source  alpha-beta filter.
#pragma once

#include "bsp/linux/pulse_thread.h"

namespace pirvs::board {

class ExposureClock {
 public:
  static constexpr int kAhead = 6;  // a frame may come to us that much later than it was taken

  void add(TimeNs t) {
    if (frames_ == 0 || t <= last_t_) return begin(t);
    if (frames_ == 1) {
      period_ns_ = static_cast<double>(t - last_t_);
      frames_ = 2;
      expected_t_ = static_cast<double>(t);
      last_t_ = t;
      return;
    }
    const double since = static_cast<double>(t) - expected_t_;
    const double periods = static_cast<double>(static_cast<int64_t>(since / period_ns_ + 0.5));
    const double off = since - periods * period_ns_;
    // A first interval that was more than one period shows here as half of one.
    if (periods < 1 || 4 * (off < 0 ? -off : off) > period_ns_) return begin(t);
    constexpr double kAlpha = 0.4, kBeta = 0.1;
    const bool settled = frames_ >= kSettled;
    expected_t_ += periods * period_ns_ + (settled ? kAlpha : 1) * off;
    period_ns_ += (settled ? kBeta : 0.5) * off / periods;
    last_t_ = t;
    if (!settled) ++frames_;
  }

  bsp::PulsePlan plan() const {
    if (frames_ < 3) return {};
    const auto period = static_cast<TimeNs>(period_ns_);
    return {static_cast<TimeNs>(expected_t_), period, last_t_ + kAhead * period};
  }

 private:
  static constexpr int kSettled = 8;

  void begin(TimeNs t) {
    frames_ = 1;
    last_t_ = t;
  }

  int frames_ = 0;
  TimeNs last_t_ = 0;
  double expected_t_ = 0, period_ns_ = 0;
};

}  // namespace pirvs::board
