// What    is known of the window's oldest keyframe from all that came before it: one 15 x 15 prior,
// carried from keyframe to keyframe as the window slides, each IMU link used once.
// In      a start's convention and expectations; then, for each keyframe that leaves the window,
//         its link to the next, both refined states, and what vision knew of its pose against the
//         others of the window.
// Out     cost e' information e - 2 gradient' e with e = x [-] mean, for the bundle.
// Frames  error order theta (in B, right), p, v (in W), b_g, b_a.
// Errors  advance() over a missing link forgets velocity and keeps the biases.
// Cost    ~20 us an advance, x86-64.
// Source  marginalization as in Leutenegger et al., IJRR 2015, section 3.5, with vision's part
//         summarized as a relative pose (the landmarks stay in the map and are used again) of the
//         information that the adjustment's own elimination leaves.
#pragma once

#include "modules/mapping/imu_link.h"
#include "modules/mapping/mapping_params.h"
#include "modules/mapping/wheel_link.h"

namespace pirvs {

struct WindowPrior {
  uint32_t sequence = 0;  // of the keyframe it speaks of; 0: none
  BodyState mean;
  Mat15 information = Mat15::Zero();
  Vec15 gradient = Vec15::Zero();
};

WindowPrior start_prior(uint32_t sequence, const BodyState& first, const MappingParams& params,
                        bool at_rest = false);
// The same prior in a world that T turns about the vertical and shifts.
void move(const SE3& T, WindowPrior& prior);
// `motions`: from the keyframe of `prior` (state a) to the next (state b); nullptr if not linked.
struct Motions {
  const Preintegration* imu = nullptr;
  const WheelPath* wheels = nullptr;  // nullptr: there are none
};
// `vision`: information about the pose of a (theta in B, p in W) against all that stays.
WindowPrior advance(const WindowPrior& prior, const BodyState& a, uint32_t sequence_b,
                    const BodyState& b, const Motions* motions, const Mat6& vision,
                    const ImuNoise& noise, const MappingParams& params);
// For a keyframe that leaves before an adjustment had it as its oldest: a cautious guess.
Mat6 guessed_vision();

}  // namespace pirvs
