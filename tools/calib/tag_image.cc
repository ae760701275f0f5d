#include "tools/calib/tag_image.h"

#include "core/math/so3.h"

namespace pirvs::tools {

bool project_tag(const Camera& camera, const Target& target, const SE3& T_CT, int tag,
                 TagImage& out) {
  out.uv.setZero();
  out.by_pose.setZero();
  out.by_lens.setZero();
  for (int k = 0; k < 4; ++k) {
    const Vec3 p_T = target.p_T(4 * tag + k);
    Vec2 uv;
    Mat23 J;
    Mat28 J_lens;
    if (!project(camera, T_CT * p_T, uv, J, J_lens)) return false;
    out.uv += uv / 4;
    out.by_pose.leftCols<3>() -= J * T_CT.R * skew(p_T) / 4;
    out.by_pose.rightCols<3>() += J / 4;
    out.by_lens += J_lens / 4;
  }
  out.by_shift = out.by_pose.rightCols<3>() * T_CT.R;
  return true;
}

StereoParts stereo_parts(const TagImage& image, const Mat3& R_C1C0, const SE3& T_C0T) {
  StereoParts out;
  out.by_p_C0T = image.by_pose.rightCols<3>() * R_C1C0;
  out.by_theta_C1C0 =
      image.by_pose.leftCols<3>() * T_C0T.R.transpose() - out.by_p_C0T * skew(T_C0T.p);
  return out;
}

}  // namespace pirvs::tools
