#include "modules/output/predictor.h"

#include <algorithm>
#include <cmath>

#include "modules/imu/imu_sample.h"

namespace pirvs {
namespace {

// The noise that makes every covariance `scale` times as large.
ImuNoise covariance_scaled(const ImuNoise& noise, double scale) {
  const double root = std::sqrt(scale);
  ImuNoise out = noise;
  for (double ImuNoise::*density :
       {&ImuNoise::gyro_noise, &ImuNoise::gyro_walk, &ImuNoise::accel_noise, &ImuNoise::accel_walk,
        &ImuNoise::bridge_rad_s, &ImuNoise::bridge_m_s2}) {
    out.*density *= root;
  }
  return out;
}

}  // namespace

void Predictor::configure(const ImuNoise& noise, double cov_scale, TimeNs bridge) {
  noise_ = covariance_scaled(noise, cov_scale);
  bridge_ = bridge;
  (void)mailbox_.take();
  begin_ = end_ = 0;
  anchored_ = in_doubt_ = false;
  anchors_missed_ = not_finite_ = 0;
}

void Predictor::fuse(const FusedState& fused) {
  mailbox_.back() = fused;
  mailbox_.publish();
}

bool Predictor::add_imu(const ImuSample& sample, Pose& out) {
  remember(in_doubt() ? doubted(sample) : sample);
  if (const FusedState* fused = mailbox_.take()) {
    anchored_ = anchor(*fused);
  } else if (anchored_) {
    propagate(at(end_ - 2), at(end_ - 1), noise_, fused_.state, fused_.cov);
  }
  if (!anchored_) return false;
  if (!is_finite()) {
    ++not_finite_;
    anchored_ = false;
    return false;
  }
  fill(out);
  return true;
}

// Across a break in time nothing can be integrated: the history begins anew, and a fused state from
// before finds no place in it.
void Predictor::interrupt() {
  begin_ = end_;
  anchored_ = false;
}

void Predictor::remember(const ImuSample& sample) {
  const TimeNs step = end_ > begin_ ? sample.t - at(end_ - 1).t : 0;
  if (end_ > begin_ && (step <= 0 || step > bridge_)) interrupt();
  history_[end_++ % kHistory] = sample;
  if (end_ - begin_ > kHistory) begin_ = end_ - kHistory;
}

// Goes on from a frame's state, over all samples since.
bool Predictor::anchor(const FusedState& fused) {
  if (!fused.running) return false;
  const TimeNs t = fused.state.t;
  size_t next = end_;  // the first sample after t
  while (next > begin_ && at(next - 1).t > t) --next;
  if (next == begin_ || at(end_ - 1).t < t) {
    ++anchors_missed_;
    return false;
  }
  fused_ = fused;
  t_frame_ = t;
  // As the door does for a frame between two samples.
  ImuSample last = at(next - 1);
  if (last.t < t && next < end_) last = interpolated(last, at(next), t);
  for (; next < end_; ++next) {
    propagate(last, at(next), noise_, fused_.state, fused_.cov);
    last = at(next);
  }
  return true;
}

bool Predictor::is_finite() const {
  const BodyState& s = fused_.state;
  return std::isfinite(s.T_WB.R.sum() + s.T_WB.p.sum() + s.v_WB.sum() + fused_.cov.sum());
}

void Predictor::fill(Pose& out) const {
  out = pose_of(fused_, t_frame_, at(end_ - 1).w_B);
  if (in_doubt()) out.trust.confidence = std::min(out.trust.confidence, kDoubtConfidence);
  out.dead_reckoning = to_seconds(out.state.t - t_frame_) > kDeadReckoning_s;
}

}  // namespace pirvs
