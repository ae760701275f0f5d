// What the stack gives out: the fused state of each frame, and the pose at each IMU sample.
// Frames  W: world, z up, origin at the first keyframe. B: IMU.
// Units   m, rad, m/s, rad/s; times in ns on the IMU's clock.
// Errors  none.
// Source  docs/architecture.md, "One feed out".
#pragma once

#include "modules/health/health.h"
#include "modules/state/body_state.h"

namespace pirvs {

// What tracking knows after a frame. state.t: middle of its exposure.
struct FusedState {
  BodyState state;
  Mat15 cov = Mat15::Zero();  // as given out: of the filter and of the map, scaled
  HealthState health = HealthState::kInitializing;
  Trust trust;
  uint16_t epoch = 0;    // poses of different epochs have no known relation
  bool in_map = false;   // the pose stands in the frame of the map that was loaded
  bool running = false;  // false: there is no state to go on from
  bool at_rest = false;
};

// A prediction from the newest fused state to the IMU sample at state.t.
struct Pose {
  BodyState state;
  TimeNs t_published = 0;  // 0: nobody knows the time on the sensors' clock (a fast replay)
  TimeNs t_frame = 0;      // of the fused state
  Vec3 w_B = Vec3::Zero();
  // theta (in B), p, v (in W): the first 9 of the error order. The biases' part stays inside.
  Mat9 cov = Mat9::Zero();
  HealthState health = HealthState::kInitializing;
  Trust trust;
  uint16_t epoch = 0;
  bool in_map = false;          // as FusedState
  bool dead_reckoning = false;  // the fused state is older than kDeadReckoning_s
};

// As a consumer gets it: the state, which may have been moved on since its frame, with a rate that
// was measured at its time.
inline Pose pose_of(const FusedState& fused, TimeNs t_frame, const Vec3& w_measured_B) {
  Pose out;
  out.state = fused.state;
  out.t_frame = t_frame;
  out.w_B = w_measured_B - fused.state.b_g;
  out.cov = fused.cov.topLeftCorner<9, 9>();
  out.health = fused.health;
  out.trust = fused.trust;
  out.epoch = fused.epoch;
  out.in_map = fused.in_map;
  return out;
}

// Three periods of a slow camera (10 Hz).
inline constexpr double kDeadReckoning_s = 0.3;

}  // namespace pirvs
