// Is a fix good enough to be looked at, and what does it say in E? And how far a receiver's own
// sigmas are to be believed.
// In      fixes in order of their stamps; where SLAM is at that time, if it is anywhere.
// Out     check(): kAccepted, or why not. measure(): place and velocity in E with variances.
// Frames  E: east, north, up. W: SLAM's world.
// Units   m, m/s, ns.
// Errors  none: FixGate is the verdict.
// Cost    ~0.5 us.
// Source  docs/gnss.md.
#pragma once

#include "core/math/geodesy.h"
#include "modules/door/items.h"
#include "modules/fusion/fusion_params.h"

namespace pirvs {

inline constexpr double kUnknownSpeed_m_s = 30;  // sigma where a receiver gives no velocity

// What became of a fix.
enum class FixGate : uint8_t {
  kAccepted,
  kNoFix,      // the receiver says that it has none
  kNotFinite,  // or not on the Earth
  kUncertain,  // the receiver says so
  kBackwards,  // not later than the fix before
  kTooLate,    // older than the history
  kFrozen,     // the same numbers as before, while the body has moved
  kPosition,   // chi square
  kVelocity,   // chi square; the position was used
  kCount
};
const char* name(FixGate gate);

struct FixMeasurement {
  Vec3 p_E = Vec3::Zero(), v_E = Vec3::Zero();
  Vec3 variance = Vec3::Zero(), velocity_variance = Vec3::Zero();
  bool has_velocity = false;
  double nis = 0;  // of the position, once it was used or rejected
};

class FixCheck {
 public:
  void configure(const FusionParams& params) { params_ = params; }
  void forget() { has_fix_ = false; }

  // t: on the IMU's clock. p_W: of the body, nullptr without SLAM. A first fix needs a height.
  FixGate check(const GnssFix& fix, TimeNs t, const Vec3* p_W, bool is_first);
  FixMeasurement measure(const GnssFix& fix, const LocalFrame& frame) const;

  // Fixes are as far off as `misfit` times what they claim; and how the next ones turned out.
  void distrust(double misfit);
  void judge(double nis);

 private:
  FusionParams params_;
  GnssFix last_;
  bool has_fix_ = false;
  Vec3 p_W_changed_ = Vec3::Zero();  // where SLAM was when the numbers last changed
  double misclaim_ = 1;              // by which the receiver's sigmas are too small
};

}  // namespace pirvs
