#include "modules/tracking/self_calibration.h"

#include <algorithm>

#include "core/math/so3.h"
#include "core/math/square.h"
#include "modules/imu/gravity.h"

namespace pirvs {
namespace {

constexpr double kBegin_s = 0.1, kBegin_rad = 0.1, kBegin_scale = 0.1;  // sigmas of the unknown
constexpr double kMemory_s = 60;  // what was seen longer ago counts little
constexpr double kStep_s = 0.5;   // a longer gap counts as so much

}  // namespace

// The whole body is where it is a little later, or as it would be with the rig turned: bias takes
// up what gravity then leaves over.
SelfCalibration::Mat15xN SelfCalibration::moved(const BodyState& state, const ImuSample& sample) {
  const Vec3 w_B = sample.w_B - state.b_g, f_B = sample.f_B - state.b_a;
  Mat15xN out = Mat15xN::Zero();
  out.block<3, 1>(kTheta, 0) = w_B;
  out.block<3, 1>(kPos, 0) = state.v_WB;
  out.block<3, 1>(kVel, 0) = state.T_WB.R * f_B - Vec3(0, 0, kGravity_m_s2);
  out.block<3, 3>(kTheta, 1).setIdentity();
  out.block<3, 3>(kBa, 1) = -skew(f_B);
  return out;
}

void SelfCalibration::begin(const BodyState& state, const ImuSample& sample) {
  S_ = moved(state, sample);
}

// An image shows the pose of moved(), the filter expects that of S. K S K' of Filter::update.
void SelfCalibration::update(const PoseInformation& seen, const Eigen::PartialPivLU<Mat6>& gain,
                             const Mat15& cov, const BodyState& state, const ImuSample& sample,
                             bool again) {
  const Mat6xN apart = moved(state, sample).topRows<6>() - S_.topRows<6>();
  const Mat6xN pull = gain.solve(seen.A * apart);
  if (!again) {
    const double dt_s = std::clamp(to_seconds(state.t - t_), 0.0, kStep_s);
    const double kept = 1 - dt_s / kMemory_s;
    information_ = kept * information_ + apart.transpose() * pull;
    score_ = kept * score_ + apart.transpose() * gain.solve(seen.b);
    t_ = state.t;
  }
  S_ += cov.leftCols<6>() * pull;
}

SelfCalibration::Estimate SelfCalibration::estimate() const {
  MatN all = information_;
  all(0, 0) += 1 / square(kBegin_s);
  all.diagonal().segment<3>(1).array() += 1 / square(kBegin_rad);
  all(kScale, kScale) += 1 / square(kBegin_scale);
  const MatN cov = all.inverse();
  const VecN x = cov * score_, sigma = cov.diagonal().cwiseSqrt();
  return {x[0], sigma[0], x.segment<3>(1), sigma.segment<3>(1), x[kScale], sigma[kScale]};
}

// Little by little: the filter has to follow, and its next residuals tell what is left.
TimeNs SelfCalibration::correct_time() {
  constexpr double kSure_s = 0.5e-3, kShare = 0.1, kStepMax_s = 1e-3, kForget_s = 5e-3;
  const Estimate now = estimate();
  if (now.time_sigma_s > kSure_s) return 0;
  const double step_s = std::clamp(kShare * now.time_s, -kStepMax_s, kStepMax_s);
  const TimeNs step = from_seconds(step_s);
  score_ -= information_.col(0) * to_seconds(step);
  // What was seen with stamps that were far off is not linear in what is left.
  const double kept = 1 - std::abs(step_s) / kForget_s;
  information_ *= kept;
  score_ *= kept;
  return step;
}

double SelfCalibration::correct_scale() {
  constexpr double kSure = 4e-3, kShare = 0.02;
  const Estimate now = estimate();
  if (now.scale_sigma > kSure) return 0;
  const double step = kShare * now.scale;
  score_ -= information_.col(kScale) * step;
  return step;
}

}  // namespace pirvs
