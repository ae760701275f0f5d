#include "tools/calib/shot_choice.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tools/calib/tag_image.h"

namespace pirvs::tools {
namespace {

constexpr double kSigma_px = 0.1;  // of a tag; sets the scale of a nat alone
constexpr double kOutlier_px = 3;

using Eigen::MatrixXd;

// What is known before the first shot: enough to make every choice well-posed.
MatrixXd prior_information(const CameraRig& rig) {
  Eigen::VectorXd sigma(rig.unknowns());
  for (int c = 0; c < rig.cameras; ++c) {
    const double width = rig.camera[c].width, f = rig.camera[c].fx;
    sigma.segment<8>(8 * c) << 0.1 * f, 0.1 * f, 0.05 * width, 0.05 * width, 0.3, 0.3, 0.3, 0.3;
  }
  if (rig.cameras == 2) sigma.tail<6>() << 0.1, 0.1, 0.1, 0.05, 0.05, 0.05;
  return sigma.cwiseAbs2().cwiseInverse().asDiagonal();
}

// Of the rig's unknowns, the board's pose marginalized.
MatrixXd shot_information(const Target& target, const CameraRig& rig, const PosedShot& shot) {
  const int n = rig.unknowns();
  MatrixXd A = MatrixXd::Zero(6 + n, 6 + n);
  for (int c = 0; c < rig.cameras; ++c) {
    const SE3 T_CC0 = c == 0 ? SE3{} : rig.T_C1C0;
    for (const SeenTag& tag : shot.shot.view[c].tags) {
      TagImage image;
      if (!project_tag(rig.camera[c], target, T_CC0 * shot.T_C0T, tag.id, image)) continue;
      if ((image.uv - tag.uv).norm() > kOutlier_px) continue;
      const StereoParts parts = stereo_parts(image, T_CC0.R, shot.T_C0T);
      MatrixXd row = MatrixXd::Zero(2, 6 + n);
      row.leftCols<3>() = image.by_pose.leftCols<3>();
      row.middleCols<3>(3) = parts.by_p_C0T;
      row.middleCols<8>(6 + 8 * c) = image.by_lens;
      if (c == 1) {
        row.middleCols<3>(6 + 16) = parts.by_theta_C1C0;
        row.middleCols<3>(6 + 19) = image.by_pose.rightCols<3>();
      }
      A.selfadjointView<Eigen::Lower>().rankUpdate(row.transpose(), 1 / (kSigma_px * kSigma_px));
    }
  }
  A = MatrixXd(A.selfadjointView<Eigen::Lower>());
  const MatrixXd own = A.topLeftCorner<6, 6>() + 1e-3 * MatrixXd::Identity(6, 6);
  return A.bottomRightCorner(n, n) -
         A.bottomLeftCorner(n, 6) * own.ldlt().solve(A.topRightCorner(6, n));
}

double log_determinant(const MatrixXd& A) {
  return 2 * MatrixXd(A.llt().matrixL()).diagonal().array().log().sum();
}

}  // namespace

std::vector<size_t> choose_shots(const Target& target, const CameraRig& rig,
                                 const std::vector<PosedShot>& shots, const ShotChoice& how) {
  std::vector<MatrixXd> information;
  for (const PosedShot& shot : shots) information.push_back(shot_information(target, rig, shot));
  MatrixXd sum = prior_information(rig);
  // A shot adds the less the more is known: an old gain bounds the new one, so that most need not
  // be asked again.
  std::vector<double> gain(shots.size(), HUGE_VAL);
  std::vector<char> fresh(shots.size(), 0);
  std::vector<size_t> out;
  double known = log_determinant(sum);
  while (out.size() < std::min(how.most, shots.size())) {
    const size_t best = size_t(std::max_element(gain.begin(), gain.end()) - gain.begin());
    if (fresh[best] == 0) {
      gain[best] = (log_determinant(sum + information[best]) - known) / 2;
      fresh[best] = 1;
      continue;
    }
    if (!(gain[best] >= how.gain_min_nats)) break;
    sum += information[best];
    known = log_determinant(sum);
    gain[best] = -HUGE_VAL;
    std::fill(fresh.begin(), fresh.end(), 0);
    out.push_back(best);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace pirvs::tools
