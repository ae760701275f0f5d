// Starts the tracker, at rest or in motion: gravity, gyro bias and velocity from a few frames.
// In      the IMU's history (a sample exactly at each frame's time) and tracks of both cameras,
//         where points seen by both give metric poses relative to the first frame at once; or of
//         one camera, where the IMU says how large the motion was (mono_start.h).
// Out     keyframes of the start in W, ready for mapping; "at rest" or "in motion".
// Frames  B0: body at the first frame of the attempt. W: gravity along -z, heading and place of
//         `origin`.
// Errors  kStale: the attempt failed (too few points, poor fit) and begins anew with the next
//         frame.
// Cost    ~0.3 ms a frame while starting, one 6 x 6 solve at the end.
// Source  Martinelli, IJCV 2014 (closed form, with known relative poses); Qin, Li, Shen, T-RO 2018,
//         section V.B (gyro bias, gravity on its sphere).
#pragma once

#include "modules/imu/imu_history.h"
#include "modules/standstill/standstill.h"
#include "modules/tracking/filter.h"
#include "modules/tracking/mono_start.h"
#include "modules/tracking/tracking_params.h"

namespace pirvs {

// Many methods: the steps of two kinds of start over the same frames.
class Starter {
 public:
  static constexpr int kKeyframesMax = static_cast<int>(StartKeyframes::capacity());
  void configure(const Camera* cameras, const ImuNoise& noise, const FilterParams& filter,
                 const TrackerParams& params, const ImuHistory* imu);
  void set_noise(const ImuNoise& noise) {
    noise_ = noise;
    for (MonoStarter& mono : mono_) mono.set_noise(noise);
  }
  void configure_wheels(const SE3& T_BV, const WheelParams& params, const WheelHistory* wheels);
  void reset();

  // True when this frame should become a keyframe of the start (its stereo matches are needed).
  bool wants_keyframe(TimeNs t) const;
  // kOk: started, keyframes() and state() hold. kEmpty: more frames needed. kStale: see above.
  // `keyframe`: this frame's observations when wants_keyframe(), otherwise nullptr.
  Status add_frame(TimeNs t, const Tracks& left, const Tracks& right,
                   const Observations* keyframe /* [kCamerasMax] */,
                   const StandstillDetector& standstill, const SE3& origin);

  // The same from camera `c` alone. An attempt is of one kind: reset() before changing over.
  Status add_mono_frame(TimeNs t, int c, const Observations* keyframe,
                        const StandstillDetector& standstill, const SE3& origin);

  const StartKeyframes& keyframes() const { return keyframes_; }
  // Carries a finished start elsewhere: T turns about the vertical and shifts.
  void move(const SE3& T);
  const BodyState& state() const { return state_; }
  const Mat15& cov() const { return cov_; }
  bool at_rest() const { return at_rest_; }
  bool idle() const { return frames_.empty(); }  // no attempt under way

 private:
  struct Frame {
    TimeNs t;
    SE3 T_B0B;
    bool keyframe;
  };
  struct Point {
    TrackId track = 0;
    Vec3 p_B0;
    Mat3 cov;
  };
  static constexpr int kFramesMax = 160;
  static constexpr int kPointsMax = 1024;

  Status begin(TimeNs t, const Observations* keyframe);
  bool has_sample_at(TimeNs t) const { return !imu_->empty() && imu_->newest().t == t; }
  int locate(SE3& T_B0B, const Tracks& left, const Tracks& right);
  void add_points(const SE3& T_B0B, const Observations* keyframe);
  void add_keyframe(TimeNs t, const Observations* keyframe);
  void forget_oldest_keyframe();
  const Point* find(int camera, TrackId track) const;
  Preintegration between(TimeNs t0, TimeNs t1, const Vec3& b_g) const;
  WheelPath way_between(TimeNs t0, TimeNs t1, const Vec3& b_g) const;
  bool solve_gyro_bias(Vec3& b_g) const;
  bool solve_gravity(const Vec3& b_g, Vec3& g_B0, Vec3& v_B0) const;
  Status finish(const SE3& origin);
  void finish_mono(const MonoStart& start, const SE3& origin);
  void finish_at_rest(const StandstillDetector& standstill, const SE3& origin);
  void seal_keyframes();

  Camera camera_[kCamerasMax];
  SE3 T_C1C0_;
  ImuNoise noise_;
  TrackerParams params_;
  Filter locator_;
  MonoStarter mono_[kCamerasMax];
  const ImuHistory* imu_ = nullptr;
  const WheelHistory* wheels_ = nullptr;
  WheelPath no_way_;  // as a path begins
  FixedVector<Frame, kFramesMax> frames_;
  FixedVector<Point, kPointsMax> points_[kCamerasMax];
  StartKeyframes keyframes_;
  Correspondences correspondences_;
  BodyState state_;
  Mat15 cov_ = Mat15::Identity();
  bool at_rest_ = false;
};

}  // namespace pirvs
