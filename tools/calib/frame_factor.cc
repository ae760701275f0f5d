#include "tools/calib/frame_factor.h"

#include <Eigen/QR>
#include <cmath>

#include "tools/calib/tag_image.h"

namespace pirvs::tools {

bool make_frame_factor(const Camera& camera, const Target& target, const View& view,
                       const SE3& T_CT, double sigma_px, FrameFactor& out, BoardRows& by_board) {
  constexpr Eigen::Index kTagsMin = 6;
  constexpr double kHuber_sigmas = 2.5;
  const auto tags = Eigen::Index(view.tags.size());
  // With rows of zero below R is square whatever the number of tags.
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2 * tags + kFrameSize, kFrameSize);
  Eigen::MatrixXd rest = Eigen::MatrixXd::Zero(rows.rows(), 1 + 3 * tags);
  by_board.tags.clear();
  Eigen::Index used = 0;
  for (const SeenTag& tag : view.tags) {
    TagImage image;
    if (!project_tag(camera, target, T_CT, tag.id, image)) continue;
    const Vec2 r = (image.uv - tag.uv) / sigma_px;
    const double e = r.norm();
    const double scale = std::sqrt(e > kHuber_sigmas ? kHuber_sigmas / e : 1);
    rows.block<2, 6>(2 * used, 0) = scale / sigma_px * image.by_pose;
    rows.block<2, kLensSize>(2 * used, 6) = scale / sigma_px * image.by_lens;
    rest.block<2, 1>(2 * used, 0) = scale * r;
    rest.block<2, 3>(2 * used, 1 + 3 * used) = scale / sigma_px * image.by_shift;
    by_board.tags.push_back(tag.id);
    ++used;
  }
  if (used < kTagsMin) return false;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows);
  rest.applyOnTheLeft(qr.householderQ().transpose());
  out.T_CT = T_CT;
  out.lens = lens_of(camera);
  out.A = qr.matrixQR().topRows<kFrameSize>().triangularView<Eigen::Upper>();
  out.c = rest.col(0).head<kFrameSize>();
  by_board.by_shift = rest.block(0, 1, kFrameSize, 3 * used);
  return out.A.allFinite();
}

}  // namespace pirvs::tools
