// Says how far the output can be trusted, and whether the device stands still.
// In      per frame: accepted correspondences, position sigma; IMU samples and image motion.
// Out     HealthState; standstill yes or no with the mean rate measured over it.
// Units   s, m, rad/s, m/s^2, px.
// Errors  none. Cost: negligible.
// Source  PIRVS paper, section IV.B (tracking with few correspondences); standstill: own.
#pragma once

#include "core/store/fixed_vector.h"
#include "modules/health/health_params.h"
#include "modules/imu/imu_sample.h"

namespace pirvs {

enum class HealthState : uint8_t { kInitializing, kTracking, kDegraded, kLost, kCount };
const char* name(HealthState state);

class Health {
 public:
  void configure(const HealthParams& params) { params_ = params; }
  void started(TimeNs t);
  // Returns true when the state changed.
  bool update(TimeNs t, int accepted, double position_sigma_m);
  void lost() { state_ = HealthState::kLost; }
  HealthState state() const { return state_; }

 private:
  HealthParams params_;
  HealthState state_ = HealthState::kInitializing;
  TimeNs last_good_ = 0;
};

// At rest: the IMU's spread over a window is that of its noise, and the image does not move.
class StandstillDetector {
 public:
  void configure(const HealthParams& params) { params_ = params; }
  void reset();
  void add_imu(const ImuSample& sample);
  void add_image_motion(double median_px, double dt_s);  // since the image before
  bool at_rest() const;
  const Vec3& mean_rate_B() const { return w_mean_; }
  const Vec3& mean_force_B() const { return f_mean_; }
  int samples() const { return count_; }

 private:
  static constexpr int kWindowMax = 256;
  HealthParams params_;
  ImuSample window_[kWindowMax];
  int count_ = 0, next_ = 0;
  Vec3 w_mean_ = Vec3::Zero(), f_mean_ = Vec3::Zero();
  double w_sigma_ = 1e9, f_sigma_ = 1e9, image_px_ = 1e9;
  double still_s_ = 0;
};

}  // namespace pirvs
