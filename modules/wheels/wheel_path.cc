#include "modules/wheels/wheel_path.h"

#include "core/math/so3.h"
#include "core/math/square.h"

namespace pirvs {

void WheelPath::configure(const SE3& T_BV, const WheelParams& params) {
  R_BV_ = T_BV.R;
  p_BV = T_BV.p;
  correlated_s_ = params.correlated_s;
  scale_sigma_ = params.scale_sigma;
}

void WheelPath::begin() {
  const WheelPath before = *this;
  *this = WheelPath{};
  R_BV_ = before.R_BV_;
  p_BV = before.p_BV;
  correlated_s_ = before.correlated_s_;
  scale_sigma_ = before.scale_sigma_;
  last_ = before.last_;
  has_last_ = before.has_last_;
}

void WheelPath::turn(const Mat3& dR_before, const Preintegration& motion, double step_s) {
  dR_sum_ += 0.5 * step_s * (dR_before + motion.dR);
  dR_ = motion.dR;
  dR_dbg_ = motion.dR_dbg;
  b_g = motion.b_g;
  open_s_ += step_s;
}

void WheelPath::speed(const WheelVelocity& velocity, bool slips) {
  const double forward =
      has_last_ ? 0.5 * (last_.forward_m_s + velocity.forward_m_s) : velocity.forward_m_s;
  if (open_s_ > 0) close(forward, velocity);
  last_ = velocity;
  has_last_ = !slips;
  holds_ = holds_ && !slips;
}

void WheelPath::end() {
  if (open_s_ <= 0) return;
  holds_ = holds_ && has_last_;
  close(last_.forward_m_s, last_);
}

void WheelPath::close(double forward_m_s, const WheelVelocity& sure) {
  if (open_s_ > kGap_s_max) holds_ = false;
  const Vec3 v_B = forward_m_s * R_BV_.col(0);
  way_B0 += dR_sum_ * v_B;
  dway_dbg -= dR_ * skew(v_B) * dR_dbg_ * open_s_;
  const Vec3 sigma(sure.sigma_m_s, sure.side_sigma_m_s, sure.side_sigma_m_s);
  const Mat3 R = dR_ * R_BV_;
  const Vec3 density = (correlated_s_ > open_s_ ? correlated_s_ : open_s_) * sigma.cwiseAbs2();
  cov += R * (open_s_ * density).asDiagonal() * R.transpose();
  dt_s += open_s_;
  dR_sum_.setZero();
  open_s_ = 0;
}

}  // namespace pirvs
