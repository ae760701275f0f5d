#include "modules/tracking/estimate.h"

#include <algorithm>

#include <Eigen/LU>

#include "core/math/so3.h"
#include "core/math/square.h"

namespace pirvs {

void Estimate::configure(const Camera* cameras, const ImuNoise& noise, const FilterParams& filter,
                         double cov_scale, const ImuHistory* history) {
  filter_.configure(cameras, noise, filter);
  filter_.tell(&self_calibration_);
  cov_scale_ = cov_scale;
  history_ = history;
}

void Estimate::configure_wheels(const SE3& T_BV, const WheelParams& params,
                                const WheelHistory* wheels) {
  T_BV_ = T_BV;
  wheel_params_ = params;
  wheels_ = wheels;
}

void Estimate::advance(TimeNs t) {
  const size_t end = wheels_ != nullptr ? wheels_->end() : 0;
  for (size_t i = end > 0 ? wheels_->first_after(filter_.state().t) : 0; i < end; ++i) {
    const WheelHistory::Entry& entry = (*wheels_)[i];
    if (entry.sample_t > t) break;
    filter_.propagate_until(entry.sample_t, *history_);
    if (!entry.slips) (void)update_wheel(entry.velocity, true);
  }
  filter_.propagate_until(t, *history_);
}

// At the newest sample's time.
void Estimate::set_now(const BodyState& state, const Mat15& cov) {
  filter_.reset(state, cov);
  filter_.propagate(history_->newest());
}

void Estimate::begin(const BodyState& state, const Mat15& cov) {
  set_now(state, cov);
  resting_ = false;
}

bool Estimate::restart(const BodyState& refined, const Mat15& cov) {
  if (!filter_.restart(refined, cov, *history_)) return false;
  resting_ = false;
  return true;
}

void Estimate::carry_over(const SE3& T) {
  BodyState state = filter_.state();
  move(T, state);
  const Mat15 A = error_transform(T);
  set_now(state, A * filter_.cov() * A.transpose());
  resting_ = false;
  T_WB_last_frame_ = T * T_WB_last_frame_;
}

void Estimate::relocate(const SE3& T_WB, double sigma_rad, double sigma_m) {
  BodyState state = filter_.state();
  state.v_WB = T_WB.R * state.T_WB.R.transpose() * state.v_WB;
  state.T_WB = T_WB;
  Mat15 cov = filter_.cov();
  cov.topRows<6>().setZero();
  cov.leftCols<6>().setZero();
  cov.diagonal().head<3>().setConstant(sigma_rad * sigma_rad);
  cov.diagonal().segment<3>(3).setConstant(sigma_m * sigma_m);
  set_now(state, cov);
}

void Estimate::stand_still(const StandstillDetector& standstill) {
  if (!standstill.at_rest()) {
    resting_ = false;
  } else if (resting_) {
    rest_cov_.diagonal().segment<3>(kBg).array() += square(standstill.rate_step());
    filter_.hold(rest_state_, rest_cov_, standstill.last_rate_B(), standstill.last_force_B());
  } else {
    filter_.update_standstill(standstill.mean_rate_B());
  }
}

int Estimate::update_if_agreed(Correspondences& correspondences, int wanted) {
  constexpr double kShare = 0.6;
  const BodyState state = filter_.state();
  const Mat15 cov = filter_.cov();
  const int accepted = filter_.update(correspondences);
  const int most = static_cast<int>(kShare * static_cast<double>(correspondences.size()));
  if (filter_.agreeing(correspondences) >= std::max(wanted, most)) return accepted;
  set_now(state, cov);
  return 0;
}

bool Estimate::unsure() const {
  constexpr double kUnsure_m = 0.05, kUnsure_rad = 0.02;
  const auto& sigma2 = filter_.cov().diagonal();
  return sigma2.segment<3>(kPos).maxCoeff() > kUnsure_m * kUnsure_m ||
         sigma2.segment<3>(kTheta).maxCoeff() > kUnsure_rad * kUnsure_rad;
}

bool Estimate::plausible(const SE3& T_WB, const Mat6& cov) const {
  constexpr double kChi2_max =
      50;  // of 6, five sigmas and more: dead reckoning errs by more than noise
  Vec6 off;
  off << so3_log(filter_.state().T_WB.R.transpose() * T_WB.R), T_WB.p - filter_.state().T_WB.p;
  const Mat6 S = pose_cov() + cov;
  return off.dot(S.inverse() * off) < kChi2_max;
}

void Estimate::note_rest() {
  resting_ = true;
  rest_state_ = filter_.state();
  rest_cov_ = filter_.cov();
}

Mat15 Estimate::cov() const {
  const Mat15x6 G = rigid_motion_under_gravity(filter_.state(), map_error_.at);
  return cov_scale_ * (filter_.cov() + G * map_error_.cov * G.transpose());
}

}  // namespace pirvs
