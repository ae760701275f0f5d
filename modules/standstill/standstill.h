// Tells a device at rest from a smooth flight, and from a scene that moves along with it.
// In      every IMU sample; the tracks of each image, in which it keeps where they stay; what the
//         IMU should say at rest, once the filter knows.
// Out     at rest or not, for how long; what the IMU said since the image before. Tracks that move
//         while the device rests are told: they are on something that moves.
// Frames  B: IMU; pixels as in Track.
// Units   s, px, rad/s, m/s^2.
// Errors  none: without images or a full window of samples there is no rest.
// Cost    ~2 us an image and camera, 256 samples; x86-64.
// Source  docs/health.md, "Standstill"; own.
#pragma once

#include "modules/frontend/frontend.h"
#include "modules/imu/imu_sample.h"
#include "modules/standstill/standstill_params.h"

namespace pirvs {

class StandstillDetector {
 public:
  static constexpr int kColumns = 16, kRows = 10;  // cells of an image, a vote each
  // What a resting IMU would measure. Unknown before a start.
  struct Expected {
    bool known = false;
    Vec3 w_B = Vec3::Zero(), f_B = Vec3::Zero();
  };

  void configure(const StandstillParams& params) { params_ = params; }
  void reset();
  void add_imu(const ImuSample& sample);
  // For each camera that delivered, then judge() once; dt_s since the image before.
  void add_tracks(Tracks& tracks, int width, int height, double dt_s);
  void judge(double dt_s, const Expected& expected);

  bool at_rest() const { return rest_s_ > 0; }
  // How long it has stood, the time that told so included; 0: it does not.
  double rest_s() const { return rest_s_; }
  // The track stands, and has for long enough to be believed.
  bool stands(const Track& track) const { return track.still_s >= params_.image_s; }
  // The track goes on and on.
  bool moves(const Track& track) const { return track.moves >= 2; }
  // At rest: the track stands, but no longer where it did: it slid along an edge, or was taken
  // along by what passed before it. Of the point that it followed it says nothing.
  bool slid(const Track& track) const { return track.moves == kSlid; }
  // Over the window of samples, and over those since the image before.
  const Vec3& mean_rate_B() const { return w_mean_; }
  const Vec3& mean_force_B() const { return f_mean_; }
  const Vec3& last_rate_B() const { return w_last_; }
  const Vec3& last_force_B() const { return f_last_; }
  int samples() const { return count_; }
  // Of the cells that voted, how many stand.
  double still_share() const { return still_share_; }

 private:
  static constexpr int kWindowMax = 256;
  static constexpr uint8_t kSlid = UINT8_MAX;
  void settle(Track& track, bool stood) const;
  void take_means();
  bool imu_quiet() const;
  bool as_expected(const Expected& expected) const;
  bool stays() const;

  StandstillParams params_;
  ImuSample window_[kWindowMax];
  int count_ = 0, next_ = 0;
  Vec3 w_mean_ = Vec3::Zero(), f_mean_ = Vec3::Zero();
  double w_sigma_ = 1e9, f_sigma_ = 1e9;
  Vec3 w_sum_ = Vec3::Zero(), f_sum_ = Vec3::Zero();  // since the last image
  int sum_count_ = 0;
  Vec3 w_last_ = Vec3::Zero(), f_last_ = Vec3::Zero();
  Vec3 w_rest_ = Vec3::Zero(), f_rest_ = Vec3::Zero();  // at rest: what the IMU has settled on
  int cells_still_ = 0, cells_ = 0;                     // of the images since judge()
  int standing_ = 0;                                    // tracks, now
  double left_ = 0;                                     // tracks that stood until lately
  double still_share_ = 0;
  double patience_s_ = 0;  // how long all but what was expected has said rest
  double rest_s_ = 0;
  bool pushed_ = false;  // the IMU alone ended rest: the image has not moved since
};

}  // namespace pirvs
