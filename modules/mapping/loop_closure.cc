#include "modules/mapping/loop_closure.h"

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

}  // namespace pirvs
