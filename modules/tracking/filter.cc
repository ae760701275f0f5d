#include "modules/tracking/filter.h"

#include <cmath>
#include <iterator>

#include <Eigen/LU>

#include "core/math/square.h"
#include "modules/imu/propagation.h"

namespace pirvs {

const char* name(Gate gate) {
  static constexpr const char* kNames[] = {"gate_accepted", "gate_behind_camera", "gate_chi2"};
  static_assert(std::size(kNames) == static_cast<size_t>(Gate::kCount));
  return kNames[static_cast<size_t>(gate)];
}

void Filter::configure(const Camera* cameras, const ImuNoise& noise, const FilterParams& params) {
  for (int c = 0; c < kCamerasMax; ++c) {
    camera_[c] = cameras[c];
    T_CB_[c] = cameras[c].T_BC.inverse();
  }
  noise_ = noise;
  params_ = params;
}

void Filter::reset(const BodyState& state, const Mat15& cov) {
  state_ = state;
  cov_ = cov;
  has_sample_ = false;
}

void Filter::propagate(const ImuSample& sample) {
  if (!has_sample_) {
    last_ = sample;
    has_sample_ = true;
    state_.t = sample.t;
    if (listener_ != nullptr) listener_->begin(state_, sample);
    return;
  }
  Mat15 F;
  pirvs::propagate(last_, sample, noise_, state_, cov_, &F);
  if (listener_ != nullptr) listener_->propagate(F);
  last_ = sample;
}

bool Filter::restart(const BodyState& state, const Mat15& cov, const ImuHistory& imu) {
  const size_t i = imu.first_at(state.t);
  if (i == imu.end() || imu[i].t != state.t) return false;
  reset(state, cov);
  propagate(imu[i]);
  return true;
}

void Filter::propagate_until(TimeNs t, const ImuHistory& imu) {
  for (size_t i = imu.first_at(last_.t + 1); i < imu.end() && imu[i].t <= t; ++i) propagate(imu[i]);
}

bool Filter::linearize(const BodyState& at, const Correspondence& c, Reprojection& out) const {
  return linearize_reprojection(at.T_WB, c, camera_[c.camera], T_CB_[c.camera],
                                params_.point_cov_scale, out);
}

int Filter::gate(Correspondences& correspondences) const {
  int accepted = 0;
  for (Correspondence& c : correspondences) {
    Reprojection m;
    c.gate = Gate::kBehindCamera;
    if (!linearize(state_, c, m)) continue;
    const Mat2 S = m.J * cov_.topLeftCorner<6, 6>() * m.J.transpose() + m.R;
    const double chi2 = m.r.dot(S.inverse() * m.r);
    c.gate = chi2 < params_.chi2_max ? Gate::kAccepted : Gate::kChi2;
    if (c.gate == Gate::kAccepted) ++accepted;
  }
  return accepted;
}

int Filter::agreeing(const Correspondences& correspondences) const {
  int agree = 0;
  for (const Correspondence& c : correspondences) {
    Reprojection m;
    if (c.gate != Gate::kAccepted || !linearize(state_, c, m)) continue;
    const Mat2 S = m.J * cov_.topLeftCorner<6, 6>() * m.J.transpose() + m.R;
    agree += m.r.dot(S.inverse() * m.r) < params_.chi2_max ? 1 : 0;
  }
  return agree;
}

void Filter::compare(const Correspondences& correspondences, PairCheck& cameras) const {
  Vec6 rate;
  rate << last_.w_B - state_.b_g, state_.v_WB;
  cameras.begin_frame(state_.t, rate);
  for (const Correspondence& c : correspondences) {
    Reprojection m;
    if (linearize(state_, c, m)) cameras.add(c.camera, m);
  }
}

PoseInformation Filter::linearize(const BodyState& at,
                                  const Correspondences& correspondences) const {
  const double c2 = params_.robust_sigma * params_.robust_sigma;
  PoseInformation info;
  for (const Correspondence& c : correspondences) {
    Reprojection m;
    if (c.gate != Gate::kAccepted || !linearize(at, c, m)) continue;
    const Mat2 R_inverse = m.R.inverse();
    const double weight = 1 / (1 + m.r.dot(R_inverse * m.r) / c2);
    const Mat26 WJ = weight * R_inverse * m.J;
    info.A.noalias() += m.J.transpose() * WJ;
    info.b.noalias() += WJ.transpose() * m.r;
  }
  return info;
}

// Only theta and p are observed, so the gain needs one 6 x 6 solve however many points there are:
// K S K' = P_c (I + A P_pp)^-1 A P_c', with P_c the first six columns of P.
int Filter::update(Correspondences& correspondences, bool again) {
  const int accepted = gate(correspondences);
  if (accepted == 0) return 0;
  const Mat6 P_pp = cov_.topLeftCorner<6, 6>();
  const Eigen::Matrix<double, 15, 6> P_c = cov_.leftCols<6>();
  const BodyState prior = state_;
  Vec15 delta = Vec15::Zero();
  Mat6 gain_core = Mat6::Zero();
  for (int i = 0; i < static_cast<int>(params_.iterations_max); ++i) {
    const PoseInformation info = linearize(state_, correspondences);
    const auto solver = (Mat6::Identity() + info.A * P_pp).partialPivLu();
    if (i == 0 && listener_ != nullptr) listener_->update(info, solver, cov_, state_, last_, again);
    const Vec15 next = P_c * solver.solve(info.b + info.A * delta.head<6>());
    gain_core = solver.solve(info.A);
    const double step = (next - delta).head<6>().norm();
    delta = next;
    state_ = boxplus(prior, delta);
    state_.t = prior.t;
    if (step < 1e-5) break;
  }
  cov_ -= P_c * gain_core * P_c.transpose();
  cov_ = (0.5 * (cov_ + cov_.transpose())).eval();
  return accepted;
}

int Filter::locate(const SE3& T_WB, const PoseGuess& guess, Correspondences& correspondences) {
  BodyState state;
  state.T_WB = T_WB;
  int accepted = 0;
  for (const double scale : {1.0, guess.tighter}) {
    Vec15 sigma = Vec15::Ones();
    sigma.head<3>().setConstant(guess.sigma_rad * scale);
    sigma.segment<3>(3).setConstant(guess.sigma_m * scale);
    reset(state, Mat15(sigma.cwiseAbs2().asDiagonal()));
    accepted = update(correspondences);
    state.T_WB = state_.T_WB;
  }
  return accepted;
}

template <int N>
Filter::Gain<N> Filter::gain(const Linear<N>& m) const {
  using MatN = Eigen::Matrix<double, N, N>;
  Gain<N> out;
  out.PH = cov_ * m.H.transpose();
  const MatN S = m.H * out.PH + m.sigma * m.sigma * MatN::Identity();
  out.S_inverse = S.inverse();
  out.K = out.PH * out.S_inverse;
  return out;
}

template <int N>
void Filter::fuse(const Linear<N>& m, const Gain<N>& gain) {
  state_ = boxplus(state_, gain.K * m.r);
  cov_ -= gain.K * gain.PH.transpose();
  cov_ = (0.5 * (cov_ + cov_.transpose())).eval();
}

WheelVerdict Filter::update_wheel(const WheelVelocity& wheel, const SE3& T_BV,
                                  const WheelParams& params, bool again) {
  const double correlated_s = params.correlated_s;
  const Linear<3> speed = linearize_wheel_speed(state_, last_, wheel, T_BV, correlated_s);
  if (!fuse_wheel(speed, per_wheel_scale(wheel, correlated_s), params, again)) {
    return WheelVerdict::kSlips;
  }
  if (!wheel.has_turn) return WheelVerdict::kUsed;
  const Linear<1> turn = linearize_wheel_turn(state_, last_, wheel, T_BV, correlated_s);
  return fuse_wheel(turn, Eigen::Matrix<double, 1, 1>(0.0), params, again) ? WheelVerdict::kUsed
                                                                           : WheelVerdict::kSkids;
}

template <int N>
bool Filter::fuse_wheel(const Linear<N>& m, const Eigen::Matrix<double, N, 1>& per_scale,
                        const WheelParams& params, bool again) {
  const Gain<N> g = gain(m);
  if (m.r.dot(g.S_inverse * m.r) > params.chi2_max) return false;
  if (listener_ != nullptr) listener_->update(m, per_scale, g.S_inverse, g.K, again);
  fuse(m, g);
  return true;
}

void Filter::update_standstill(const Vec3& w_mean_B) {
  fuse(linearize_zero_velocity(state_, params_.standstill_sigma_m_s));
  fuse(linearize_zero_rate(state_, w_mean_B, params_.standstill_sigma_rad_s));
}

// Integrating the IMU at rest would only add its noise: the pose stays, as does its covariance but
// for what detection may overlook, and velocity is zero by what rest means.
void Filter::hold(const BodyState& state, const Mat15& cov, const Vec3& w_mean_B,
                  const Vec3& f_mean_B) {
  const TimeNs t = state_.t;
  const double dt = to_seconds(t - state.t);
  state_ = state;
  state_.t = t;
  state_.v_WB.setZero();
  cov_ = cov;
  cov_.middleRows<3>(kVel).setZero();
  cov_.middleCols<3>(kVel).setZero();
  cov_.diagonal().segment<3>(kVel).setConstant(square(params_.standstill_sigma_m_s));
  cov_.diagonal().segment<3>(kTheta).array() += square(params_.standstill_turn_rad) * dt;
  cov_.diagonal().segment<3>(kPos).array() += square(params_.standstill_shift_m) * dt;
  cov_.diagonal().segment<3>(kBg).array() += square(noise_.gyro_walk) * dt;
  cov_.diagonal().segment<3>(kBa).array() += square(noise_.accel_walk) * dt;
  if (listener_ != nullptr) listener_->begin(state_, last_);
  fuse(linearize_zero_rate(state_, w_mean_B, params_.standstill_sigma_rad_s));
  fuse(linearize_gravity(state_, f_mean_B, params_.standstill_sigma_m_s2));
}

}  // namespace pirvs
