// Tells a device at rest from a smooth flight, and from a scene that moves along with it.
// In      the IMU's history; the tracks of each image, of which it notes where they stay; what the
//         IMU should say at rest, once the filter knows.
// Out     at rest or not, for how long; what the IMU said since the image before. Tracks that move
//         while the device rests are told: they are on something that moves.
// Frames  B: IMU; pixels as in Track.
// Units   s, px, rad/s, m/s^2.
// Errors  none: without images or a full window of samples there is no rest.
// Cost    ~2 us an image and camera, 256 samples; x86-64.
// Source  docs/health.md, "Standstill"; own.
#pragma once

#include "core/base/limits.h"
#include "core/camera/camera.h"
#include "modules/frontend/track_table.h"
#include "modules/imu/imu_history.h"
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
  void reset();  // whenever the history is cleared
  // For each camera that delivered, then judge() once; dt_s since the image before.
  void add_tracks(const Camera& camera, int c, const Tracks& tracks, double dt_s);
  void judge(const ImuHistory& imu, double dt_s, const Expected& expected);

  bool at_rest() const { return rest_s_ > 0; }
  // How long it has stood, the time that told so included; 0: it does not.
  double rest_s() const { return rest_s_; }
  // Camera c's track stands, and has for long enough to be believed.
  bool stands(int c, const Track& track) const { return stands(stays_[c].get(track)); }
  // The track goes on and on.
  bool moves(int c, const Track& track) const { return stays_[c].get(track).moves >= 2; }
  // At rest: the track stands, but no longer where it did: it slid along an edge, or was taken
  // along by what passed before it. Of the point that it followed it says nothing.
  bool slid(int c, const Track& track) const { return stays_[c].get(track).moves == kSlid; }
  // At rest: by how much the gyro has just changed although picture and gravity stand; else 0.
  double rate_step() const { return rate_step_; }
  // The picture stood while the IMU gained more speed, or turned more, than it can err by: since
  // then the place is that in what moves along, not in the world. Until reset().
  bool moved_along() const { return moved_along_; }
  // Over the window of samples, and over those since the image before.
  const Vec3& mean_rate_B() const { return w_mean_; }
  const Vec3& mean_force_B() const { return f_mean_; }
  const Vec3& last_rate_B() const { return w_last_; }
  const Vec3& last_force_B() const { return f_last_; }

 private:
  static constexpr uint8_t kSlid = UINT8_MAX;
  // Where a track stays.
  struct Stay {
    float x = 0, y = 0, still_s = -1;  // its place, and for how long; -1: not yet begun
    float x_stood = 0, y_stood = 0;    // the place when it began to stand
    uint8_t moves = 0;                 // how often it left a place since it last stood
  };
  bool stands(const Stay& stay) const { return stay.still_s >= params_.image_s; }
  static void follow(const Track& track, double dt_s, double stay_px, Stay& stay);
  void settle(const Track& track, bool stood, Stay& stay) const;
  void take_means(const ImuHistory& imu);
  bool imu_quiet() const;
  bool as_expected(const Expected& expected) const;
  bool gyro_steps() const;
  bool stays() const;
  void note_push(bool image_still, double dt_s);

  StandstillParams params_;
  TrackTable<Stay> stays_[kCamerasMax];
  int count_ = 0;       // samples in the window
  size_t imu_end_ = 0;  // of the history, at the last image
  Vec3 w_mean_ = Vec3::Zero(), f_mean_ = Vec3::Zero();
  double w_sigma_ = 1e9, f_sigma_ = 1e9;
  Vec3 w_last_ = Vec3::Zero(), f_last_ = Vec3::Zero();
  Vec3 w_rest_ = Vec3::Zero(), f_rest_ = Vec3::Zero();  // at rest: what the IMU has settled on
  Vec3 w_begin_ = Vec3::Zero();                         // and said when rest began
  double rate_step_ = 0;
  int since_step_ = 0;               // samples
  int cells_still_ = 0, cells_ = 0;  // of the images since judge()
  int standing_ = 0;                 // tracks, now
  double left_ = 0;                  // tracks that stood until lately
  double patience_s_ = 0;            // how long all but what was expected has said rest
  double rest_s_ = 0;
  Vec3 v_pushed_ = Vec3::Zero(), turn_pushed_ = Vec3::Zero();  // since the picture alone stands
  bool moved_along_ = false;
  double unstill_s_ = 0;  // since the picture last stood
  bool pushed_ = false;   // the IMU alone ended rest: the image has not moved since
};

}  // namespace pirvs
