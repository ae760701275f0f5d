// The other side's clock against ours, by questions and answers (TIMESYNC).
// In      ask(): the time that goes out with a question; answered(): what came back.
// Out     ours(): a time of theirs on our clock.
// Errors  ours: kEmpty: no answer has come yet. An answer to no question of ours, or one that took
//         longer than kTripMax_ns, changes nothing.
// Cost    ~10 ns.
// Source  NTP's clock filter (RFC 5905, section 10): of the last answers the quickest is right.
#pragma once

#include <cstdint>

#include "core/base/status.h"
#include "core/base/time.h"

namespace pirvs {

class PeerClock {
 public:
  static constexpr TimeNs kTripMax_ns = 100'000'000;
  static constexpr int kKept = 8;

  void ask(TimeNs now) { asked_t_ = now; }

  void answered(TimeNs now, TimeNs asked_t, TimeNs theirs) {
    if (asked_t != asked_t_ || asked_t_ == 0) return;
    asked_t_ = 0;
    const TimeNs trip = now - asked_t;
    if (trip < 0 || trip > kTripMax_ns || theirs < 0 || theirs > kTimeMax) return;
    answers_[count_++ % kKept] = {trip, theirs - (asked_t + trip / 2)};
  }

  Result<TimeNs> ours(TimeNs theirs) const {
    if (count_ == 0 || theirs < 0 || theirs > kTimeMax) return Status::kEmpty;
    const int known = count_ < kKept ? static_cast<int>(count_) : kKept;
    Answered best = answers_[0];
    for (int i = 1; i < known; ++i) {
      if (answers_[i].trip_ns < best.trip_ns) best = answers_[i];
    }
    return theirs - best.offset_ns;
  }

 private:
  static constexpr TimeNs kTimeMax = INT64_MAX / 4;  // sums stay in range

  struct Answered {
    TimeNs trip_ns = 0, offset_ns = 0;
  };

  TimeNs asked_t_ = 0;  // 0: no question is open
  Answered answers_[kKept];
  uint32_t count_ = 0;
};

}  // namespace pirvs
