// Metric start from one moving camera and the IMU: gyro bias, velocity, gravity and scale.
// In      keyframes (their observations in one camera, times) over one to two seconds; the samples
//         between the first and the last; the wheels' speeds, which tell the scale at once.
// Out     MonoStart: what the first keyframe's body moved by and how sure that is. Found in three
//         steps: the gyro bias from epipolar geometry; velocity, gravity and points from a linear
//         system; all of them and the accelerometer bias by least squares on the image.
// Frames  B0: body at the first keyframe. Error order b_g, b_a, v_B0, g_B0 (two, tangent).
// Errors  kEmpty: too few tracks or too little parallax. kStale: no fit. kBadData: fits, but the
//         motion does not say how large it is (scale_sigma above its limit). Look longer.
// Cost    ~3 ms a try with 10 keyframes and 150 tracks, x86-64.
// Source  Martinelli, IJCV 2014 (closed form); Kneip, Lynen, ICCV 2013 (rotation from epipolar
//         planes); He et al., CVPR 2023 (gyro bias so); docs/conventions.md, "A start from one
//         camera".
#pragma once

#include "core/base/status.h"
#include "core/camera/camera.h"
#include "modules/imu/imu_history.h"
#include "modules/map/messages.h"
#include "modules/tracking/epipolar.h"
#include "modules/tracking/tracking_params.h"
#include "modules/wheels/wheel_history.h"

namespace pirvs {

using StartKeyframes = FixedVector<KeyframeMessage, kStartKeyframesMax>;

struct MonoStart {
  enum : int { kBg = 0, kBa = 3, kVel = 6, kGravity = 9, kUnknowns = 11 };
  using Mat = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  Vec3 b_g = Vec3::Zero(), b_a = Vec3::Zero(), v_B0 = Vec3::Zero(), g_B0 = Vec3::Zero();
  Mat32 g_tangent = Mat32::Zero();  // columns span gravity's sphere at g_B0
  Mat cov = Mat::Zero();
  double scale_sigma = 1e9;  // of the farthest displacement, as a share of it
  double residual_px = 1e9;  // rms
  int tracks = 0;            // that fit
};

class MonoStarter {
 public:
  void set_noise(const ImuNoise& noise) { noise_ = noise; }
  void configure(const Camera& camera, int index, const ImuNoise& noise,
                 const TrackerParams& params);
  // Of a vehicle, if there are any; a path as it begins.
  struct Wheels {
    const WheelHistory* history = nullptr;
    WheelPath path;
  };
  Status solve(const ImuHistory& imu, const Wheels& wheels, const StartKeyframes& keyframes,
               MonoStart& out);

 private:
  static constexpr int kFramesMax = static_cast<int>(StartKeyframes::capacity());
  static constexpr int kTracksSeen = static_cast<int>(BearingPairs::capacity());
  struct Sighting {
    int frame;
    Vec2 uv;
    Vec3 f_B;  // bearing in the axes of B
  };
  struct Track {
    TrackId id;
    FixedVector<Sighting, kFramesMax> seen;
    bool good;
    Vec3 p_B0, trial;
    Mat3 H_inverse;
    Vec3 b;
    Eigen::Matrix<double, MonoStart::kUnknowns, 3> W;
  };
  struct Frame {
    TimeNs t;
    Preintegration motion;  // from frame 0
  };
  using Vec = Eigen::Matrix<double, MonoStart::kUnknowns, 1>;

  void integrate_all(const ImuHistory& imu, const Wheels& wheels, const MonoStart& at);
  Vec3 way_residual(const MonoStart& at) const;
  void gather(const StartKeyframes& keyframes);
  int drop_still_tracks();
  bool solve_gyro_bias(const ImuHistory& imu, Vec3& b_g) const;
  bool add_epipolar_pair(int i, int j, const Preintegration& motion, Mat3& H, Vec3& g) const;
  bool solve_linear(const ImuHistory& imu, MonoStart& out);
  void add_way(bool weighted, Mat6& H, Vec6& rhs) const;
  double linear_pass(const Vec3& g_start_B0, bool weighted, Vec3& v_B0, Vec3& g_B0);
  bool refine(MonoStart& out);
  SE3 pose(const MonoStart& at, int frame) const;
  double linearize(const MonoStart& at, MonoStart::Mat& H, Vec& b);
  double cost(const MonoStart& at) const;
  int drop_misfits(const MonoStart& at);
  void judge(const MonoStart::Mat& H, MonoStart& out) const;

  Camera camera_;
  SE3 T_CB_;
  int index_ = 0;
  ImuNoise noise_;
  TrackerParams params_;
  FixedVector<Frame, kFramesMax> frames_;
  FixedVector<Track, kTracksSeen> tracks_;
  WheelPath way_;  // from the first frame to the last, if it holds
  Mat3 way_information_ = Mat3::Zero();
};

// The covariance of the state at keyframe k, error order of BodyState; place and heading of the
// first keyframe are convention.
Mat15 mono_start_cov(const MonoStart& start, const Preintegration& motion, const Mat3& R_WB0);

}  // namespace pirvs
