// A place was recognised: spreads what the newest keyframe is off over all keyframes since the old
// place, each by its share of the error that came up on the way.
// In      for each keyframe since, oldest first: its place and the covariance of the error that it
//         added to its predecessor's; how far the newest is off: a turn about the vertical and a
//         shift (4), with covariance R.
// Out     for each keyframe its correction (theta, p) about its own place, and the covariance that
//         is left of its error against the old place.
// Frames  all in W, as map_error.h. The tilt is gravity's and stays.
// Errors  none. Cost: ~2 us a keyframe.
// Source  a random walk's smoother, e.g. Rauch, Tung, Striebel, 1965; docs/adr/8.
#pragma once

#include "modules/map/map_error.h"

namespace pirvs {

struct LoopStep {
  Vec3 p_WB;
  Mat6 added;
};

struct LoopCorrection {
  Vec6 xi = Vec6::Zero();
  Mat6 left = Mat6::Zero();
};

void spread_loop(const LoopStep* steps, int count, const Vec4& off, const Mat4& R,
                 LoopCorrection* out);

}  // namespace pirvs
