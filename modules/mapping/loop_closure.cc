#include "modules/mapping/loop_closure.h"

#include <algorithm>

#include <Eigen/LU>

namespace pirvs {

void spread_loop(const LoopStep* steps, int count, const Vec4& off, const Mat4& R,
                 LoopCorrection* out) {
  if (count == 0) return;
  const Vec3& p_newest = steps[count - 1].p_WB;
  Mat6 D = Mat6::Zero();  // of the error since the old place, about the keyframe's own
  for (int k = 0; k < count; ++k) {
    if (k > 0) D = error_about(steps[k].p_WB, steps[k - 1].p_WB, D);
    D += steps[k].added;
    out[k].left = D;
  }
  const Mat4 S = gauge_of(D) + R;
  const Mat4 S_inverse = S.inverse();
  for (int k = 0; k < count; ++k) {
    const Mat6 carried = motion_about(p_newest, steps[k].p_WB);
    const Eigen::Matrix<double, 6, 4> C = (out[k].left * carried.transpose()).rightCols<4>();
    const Eigen::Matrix<double, 6, 4> K = C * S_inverse;
    out[k].xi = K * off;
    out[k].xi.head<2>().setZero();
    out[k].left = (out[k].left - K * C.transpose()).eval();
  }
}

void LoopCloser::close(const KeyframeMessage& message, WorkingMap& map, WindowPrior& prior) {
  const size_t begin = map.place_after(message.closes_to, map.run_begin());
  const size_t count = map.size() - begin;
  for (size_t i = 0; i < count; ++i) {
    steps_[i] = {map.keyframe(begin + i).state.T_WB.p, map.keyframe(begin + i).added};
  }
  spread_loop(steps_, static_cast<int>(count), message.off, message.off_cov, corrections_);
  const Keyframe* const old = begin > 0 ? &map.keyframe(begin - 1) : nullptr;
  for (size_t i = 0; i < count; ++i) {
    Keyframe& moved = map.keyframe(begin + i);
    motions_[i] = motion_of(corrections_[i].xi, moved.state.T_WB.p);
    moved.error = corrections_[i].left;
    if (old != nullptr) {
      moved.error += error_about(moved.state.T_WB.p, old->state.T_WB.p, old->error);
    }
    move(motions_[i], moved.state);
    if (moved.sequence == prior.sequence) move(motions_[i], prior);
  }
  map.errors().newest = map.newest().error;
  const uint32_t sequence_begin = map.keyframe(begin).sequence;
  for (size_t slot = 0; slot < map.points().capacity(); ++slot) {
    Landmark* point = map.points().at(slot);
    if (point == nullptr || point->kept || point->last_keyframe < sequence_begin) continue;
    const uint32_t seen = std::min(point->last_keyframe, map.newest().sequence);
    move(motions_[map.place_after(seen, begin) - begin - 1], *point);
  }
}

}  // namespace pirvs
