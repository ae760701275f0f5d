#include "tools/calib/shot_choice.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "tools/calib/lens.h"

namespace pirvs::tools {
namespace {

constexpr double kSigma_px = 0.3;  // of a corner; sets the scale of a nat alone
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

constexpr int kOwn = 8;  // of a shot: the board's pose and the inset in each image

// Of the rig's unknowns, those of the shot marginalized.
MatrixXd shot_information(const Target& target, const CameraRig& rig, const PosedShot& shot) {
  const int n = rig.unknowns();
  MatrixXd A = MatrixXd::Zero(kOwn + n, kOwn + n);
  for (int c = 0; c < rig.cameras; ++c) {
    const Mat3 R_CC0 = c == 0 ? Mat3(Mat3::Identity()) : rig.T_C1C0.R;
    for (const Corner& corner : shot.shot.view[c].corners) {
      const Vec3 outward = target.outward_T(corner.id);
      const Vec3 p_T = target.p_T(corner.id) - shot.inset_m[c] * outward;
      const Vec3 p_C0 = shot.T_C0T * p_T;
      Vec2 uv;
      Mat23 J;
      Mat28 J_lens;
      const Vec3 p_C = c == 0 ? p_C0 : rig.T_C1C0 * p_C0;
      if (!project(rig.camera[c], p_C, uv, J, J_lens)) continue;
      if ((uv - corner.uv).norm() > kOutlier_px) continue;
      MatrixXd row = MatrixXd::Zero(2, kOwn + n);
      row.leftCols<3>() = -J * R_CC0 * shot.T_C0T.R * skew(p_T);
      row.middleCols<3>(3) = J * R_CC0;
      row.col(6 + c) = -J * R_CC0 * shot.T_C0T.R * outward;
      row.middleCols<8>(kOwn + 8 * c) = J_lens;
      if (c == 1) {
        row.middleCols<3>(kOwn + 16) = -J * R_CC0 * skew(p_C0);
        row.middleCols<3>(kOwn + 19) = J;
      }
      A.selfadjointView<Eigen::Lower>().rankUpdate(row.transpose(), 1 / (kSigma_px * kSigma_px));
    }
  }
  A = MatrixXd(A.selfadjointView<Eigen::Lower>());
  const MatrixXd own = A.topLeftCorner<kOwn, kOwn>() + 1e-3 * MatrixXd::Identity(kOwn, kOwn);
  return A.bottomRightCorner(n, n) -
         A.bottomLeftCorner(n, kOwn) * own.ldlt().solve(A.topRightCorner(kOwn, n));
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
