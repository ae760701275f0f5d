// Distributes a loop error over the keyframes since the revisited one, in proportion to the
// covariance that each added.
// In      for each keyframe since, oldest first: its place and the covariance of the error that it
//         added to its predecessor's; how far the newest is off: a turn about the vertical and a
//         shift (4), with covariance R.
// Out     for each keyframe its correction (theta, p) about its own place, and the covariance that
//         is left of its error against the old place.
//         LoopCloser does that to a map, and takes each point along with the keyframe that saw it
//         last.
// Frames  all in W, as map_error.h. The tilt is gravity's and stays.
// Errors  none. Cost: ~2 us a keyframe, and one pass over the points. Mapping's core alone.
// Source  a random walk's smoother, e.g. Rauch, Tung, Striebel, 1965; docs/adr/8.
#pragma once

#include "modules/mapping/window_prior.h"
#include "modules/mapping/working_map.h"

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

class LoopCloser {
 public:
  // message.close; its keyframe is the map's newest already. The prior moves with its keyframe.
  void close(const KeyframeMessage& message, WorkingMap& map, WindowPrior& prior);

 private:
  // Working memory, too large for a stack.
  LoopStep steps_[kKeyframesMax];
  LoopCorrection corrections_[kKeyframesMax];
  SE3 motions_[kKeyframesMax];
};

}  // namespace pirvs
