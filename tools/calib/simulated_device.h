// What    A simulated device by seed and a recording of a board that it makes, moved by a hand:
//         images of tags as exact places with noise, or drawn (board_camera.h); IMU samples with scale,
//         misalignment, biases and a clock of their own.
// In      A seed; how the recording is.
// Out     The truth; shots and samples as the files of a recording have them.
// Frames  T: the board; B: the accelerometer; C0, C1: the cameras. measured = matrix * true + bias;
//         t_imu = t_camera + offset_s.
// Errors  none.
// Source  PIRVS paper, section II: 640 x 480 fisheyes, 65 mm apart.
#pragma once

#include <vector>

#include "modules/imu/imu_intrinsics.h"
#include "modules/imu/imu_noise.h"
#include "tools/calib/camera_adjustment.h"
#include "tools/sim/random.h"

namespace pirvs::tools {

struct SimulatedRecording {
  double duration_s = 45;
  double frames_hz = 30;
  double imu_hz = 200;
  double tag_px = 0.05;  // noise of a tag's image
  double turning = 1;    // of the motion's angles
  double moving = 1;     // of its places
  double roll = 1;       // of its angles about the line of sight
  double rest_s = 0;     // at rest before and after
};

class SimulatedDevice {
 public:
  Target target;  // what its yaml says
  Target board;   // what it is: as uneven as boards are taken to be
  CameraRig rig;
  double offset_s;
  ImuIntrinsics imu;
  ImuNoise noise;

  explicit SimulatedDevice(uint64_t seed);

  // What every device of this kind is meant to be.
  static CameraRig nominal_rig();
  static constexpr double kNominalOffset_s = 0.017;

  std::vector<Shot> shots(const SimulatedRecording& how);
  std::vector<ImuSample> samples(const SimulatedRecording& how);
  // Stamps of the shots, and T_C0T at any stamp of the cameras.
  std::vector<TimeNs> stamps(const SimulatedRecording& how) const;
  SE3 pose(const SimulatedRecording& how, TimeNs t) const;

 private:
  struct Motion {
    SE3 T_TB;
    Vec3 w_B, a_T;
  };
  double uniform(double a) { return random_.uniform(-a, a); }
  Vec3 vec(double a);
  Vec3 normal();
  Vec3 wave(const SimulatedRecording& how, int k, double t_s) const;
  Motion motion(const SimulatedRecording& how, double t_s) const;
  void see(const SimulatedRecording& how, const Camera& camera, const SE3& T_CT, View& out);

  Random random_;
  double phase_[18];
};

}  // namespace pirvs::tools
