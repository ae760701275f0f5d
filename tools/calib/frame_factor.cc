#include "tools/calib/frame_factor.h"

#include <Eigen/QR>
#include <cmath>

#include "core/math/so3.h"

namespace pirvs::tools {

bool make_frame_factor(const Camera& camera, const Target& target, const View& view,
                       const SE3& T_CT, double inset_m, double sigma_px, FrameFactor& out) {
  constexpr Eigen::Index kCornersMin = 8;
  constexpr double kHuber_sigmas = 2.5;
  Eigen::MatrixXd rows(Eigen::Index(2 * view.corners.size()) + kFrameSize + 1, kFrameSize + 2);
  rows.setZero();  // with rows of zero below R is square whatever the number of corners
  Eigen::Index used = 0;
  for (const Corner& corner : view.corners) {
    const Vec3 outward = target.outward_T(corner.id);
    const Vec3 p_T = target.p_T(corner.id) - inset_m * outward;
    Vec2 uv;
    Mat23 J;
    Mat28 J_lens;
    if (!project(camera, T_CT * p_T, uv, J, J_lens)) continue;
    const Vec2 r = (uv - corner.uv) / sigma_px;
    const double e = r.norm();
    const double scale = std::sqrt(e > kHuber_sigmas ? kHuber_sigmas / e : 1);
    // The inset comes first: without its row the rest has it marginalized.
    rows.block<2, 1>(2 * used, 0) = -scale / sigma_px * J * T_CT.R * outward;
    rows.block<2, 3>(2 * used, 1) = -scale / sigma_px * J * T_CT.R * skew(p_T);
    rows.block<2, 3>(2 * used, 4) = scale / sigma_px * J;
    rows.block<2, kLensSize>(2 * used, 7) = scale / sigma_px * J_lens;
    rows.block<2, 1>(2 * used, kFrameSize + 1) = scale * r;
    ++used;
  }
  if (used < kCornersMin) return false;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows);
  const Eigen::MatrixXd R = qr.matrixQR().topRows(kFrameSize + 1).triangularView<Eigen::Upper>();
  out.T_CT = T_CT;
  out.lens = lens_of(camera);
  out.A = R.block<kFrameSize, kFrameSize>(1, 1);
  out.c = R.bottomRightCorner<kFrameSize, 1>();
  return out.A.allFinite();
}

}  // namespace pirvs::tools
