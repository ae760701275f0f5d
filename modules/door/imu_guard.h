// Tells IMU samples that a body can have felt from those that a fault has made.
// In      put(): raw samples as they come; finish(): no more will come, what is in doubt is
//         dropped.
// Out     get(): the good ones, stamps rising. A sample that looks like a spike, or whose stamp is
//         far ahead, waits for the next one to be judged: band-limited sensors do not jump for one
//         sample. broken: time does not connect to the sample before.
// Units   rad/s, m/s^2, ns.
// Errors  What is dropped is counted by name, here and as a gap where it leaves one.
// Cost    ~10 ns a sample; one sample of latency where one is suspect.
// Source  A median of three that leaves alone what is not an outlier: a spike is rare, and stands
//         out of how much the samples before it differed from one another.
#pragma once

#include "bsp/api/imu.h"
#include "core/store/fixed_vector.h"
#include "modules/door/door_loss.h"
#include "modules/door/door_params.h"

namespace pirvs {

struct GoodSample {
  ImuSample sample;  // gap_s says whether a line leads to it
  bool broken = false;
  TimeNs step = 0;  // by so much more than its period the stamp stepped: lost samples, or the clock
};

class ImuGuard {
 public:
  void configure(const DoorParams& params);
  // Only when get() has nothing.
  void put(const ImuSample& raw, DoorLosses& losses);
  void finish(DoorLosses& losses);
  bool get(GoodSample& out);

 private:
  enum class Doubt : uint8_t { kNone, kValue, kStamp };

  bool impossible(const ImuSample& raw, DoorLosses& losses);
  bool backwards(const ImuSample& raw, DoorLosses& losses);
  Doubt doubt(const ImuSample& raw) const;
  bool confirmed_by(const ImuSample& next) const;
  bool jumps(const ImuSample& a, const ImuSample& b) const;
  void note_spread(const ImuSample& before, const ImuSample& raw);
  void accept(const ImuSample& sample, DoorLosses& losses);

  DoorParams params_;
  TimeNs break_ = 0, bridge_ = 0, gap_ = 0, clock_step_ = 0;
  TimeNs period_ = 0;  // of the samples, as they come
  ImuSample last_;     // accepted
  bool has_last_ = false;
  ImuSample doubted_;
  Doubt why_doubted_ = Doubt::kNone;
  ImuSample raw_;                            // whatever came before, for the stuck and the shaken
  double rate_limit_ = 0, force_limit_ = 0;  // beyond which a difference is a spike's
  double rate_spread2_ = 0, force_spread2_ = 0;  // mean square of differences, largest axis
  float equal_ = 0;
  bool is_back_ = false;  // time has run back, and for how long it has gone on from there
  TimeNs back_begin_ = 0, back_last_ = 0;
  bool next_is_broken_ = false;
  TimeNs next_step_ = 0;
  FixedVector<GoodSample, 2> good_;  // to be handed out, oldest first
};

}  // namespace pirvs
