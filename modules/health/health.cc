#include "modules/health/health.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace pirvs {

namespace {

constexpr double kFlowNoise_px = 0.04;  // of the median over all tracks, between two images

}  // namespace

const char* name(HealthState state) {
  static constexpr const char* kNames[] = {"initializing", "tracking", "degraded", "lost"};
  static_assert(std::size(kNames) == static_cast<size_t>(HealthState::kCount));
  return kNames[static_cast<size_t>(state)];
}

void Health::started(TimeNs t) {
  state_ = HealthState::kTracking;
  last_good_ = t;
}

bool Health::update(TimeNs t, int accepted, double position_sigma_m) {
  const HealthState before = state_;
  if (accepted >= static_cast<int>(params_.matches_min)) {
    last_good_ = t;
    state_ = HealthState::kTracking;
  } else if (to_seconds(t - last_good_) > params_.lost_s &&
             position_sigma_m > params_.lost_sigma_m) {
    state_ = HealthState::kLost;
  } else {
    state_ = HealthState::kDegraded;
  }
  return state_ != before;
}

void StandstillDetector::reset() {
  count_ = next_ = 0;
  still_s_ = 0;
  w_sigma_ = f_sigma_ = image_px_ = 1e9;
}

void StandstillDetector::add_imu(const ImuSample& sample) {
  const int window = std::min(kWindowMax, static_cast<int>(params_.standstill_window));
  window_[next_] = sample;
  next_ = (next_ + 1) % window;
  count_ = std::min(count_ + 1, window);
}

void StandstillDetector::add_image_motion(double median_px, double dt_s) {
  image_px_ = median_px;
  const bool still = median_px < params_.standstill_image_px_s * dt_s + kFlowNoise_px;
  still_s_ = still ? still_s_ + dt_s : 0.0;
  if (count_ == 0) return;
  w_mean_.setZero();
  f_mean_.setZero();
  for (int i = 0; i < count_; ++i) {
    w_mean_ += window_[i].w_B;
    f_mean_ += window_[i].f_B;
  }
  w_mean_ /= count_;
  f_mean_ /= count_;
  double w2 = 0, f2 = 0;
  for (int i = 0; i < count_; ++i) {
    w2 += (window_[i].w_B - w_mean_).squaredNorm();
    f2 += (window_[i].f_B - f_mean_).squaredNorm();
  }
  w_sigma_ = std::sqrt(w2 / count_);
  f_sigma_ = std::sqrt(f2 / count_);
}

bool StandstillDetector::at_rest() const {
  const bool full = count_ >= static_cast<int>(params_.standstill_window);
  return full && w_sigma_ < params_.standstill_gyro_rad_s &&
         f_sigma_ < params_.standstill_accel_m_s2 && still_s_ > params_.standstill_image_s;
}

}  // namespace pirvs
