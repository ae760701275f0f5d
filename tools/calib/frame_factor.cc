#include "tools/calib/frame_factor.h"

#include <Eigen/QR>
#include <cmath>

#include "tools/calib/tag_image.h"

namespace pirvs::tools {

bool make_frame_factor(const Camera& camera, const Target& target, const View& view,
                       const SE3& T_CT, double sigma_px, FrameFactor& out) {
  constexpr Eigen::Index kTagsMin = 6;
  constexpr double kHuber_sigmas = 2.5;
  Eigen::MatrixXd rows(Eigen::Index(2 * view.tags.size()) + kFrameSize, kFrameSize + 1);
  rows.setZero();  // with rows of zero below R is square whatever the number of tags
  Eigen::Index used = 0;
  for (const SeenTag& tag : view.tags) {
    TagImage image;
    if (!project_tag(camera, target, T_CT, tag.id, image)) continue;
    const Vec2 r = (image.uv - tag.uv) / sigma_px;
    const double e = r.norm();
    const double scale = std::sqrt(e > kHuber_sigmas ? kHuber_sigmas / e : 1);
    rows.block<2, 6>(2 * used, 0) = scale / sigma_px * image.by_pose;
    rows.block<2, kLensSize>(2 * used, 6) = scale / sigma_px * image.by_lens;
    rows.block<2, 1>(2 * used, kFrameSize) = scale * r;
    ++used;
  }
  if (used < kTagsMin) return false;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows);
  const Eigen::MatrixXd R = qr.matrixQR().topRows(kFrameSize).triangularView<Eigen::Upper>();
  out.T_CT = T_CT;
  out.lens = lens_of(camera);
  out.A = R.leftCols<kFrameSize>();
  out.c = R.rightCols<1>();
  return out.A.allFinite();
}

}  // namespace pirvs::tools
