// What    A device by seed and a recording of a board that it makes, for tests: exact places of
//         tags along a hand's smooth motion, with noise; IMU samples with scale, misalignment,
//         biases and a clock of their own.
// In      A seed; how the recording is.
// Out     The truth; shots and samples as the files of a recording have them.
// Frames  T: the board; B: the accelerometer; C0, C1: the cameras. measured = matrix * true + bias;
//         t_imu = t_camera + offset_s.
// Errors  none.
// Source  the fisheye of the device (modules/testing.h): 640 x 480, cameras 65 mm apart.
#pragma once

#include <vector>

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "modules/testing.h"
#include "tools/calib/imu_camera.h"
#include "tools/calib/tag_image.h"
#include "tools/sim/random.h"

namespace pirvs::tools {

struct TestRecording {
  double duration_s = 45;
  double frames_hz = 30;
  double imu_hz = 200;
  double tag_px = 0.05;  // noise of a tag's image
  double turning = 1;    // of the motion's angles
  double moving = 1;     // of its places
  double roll = 1;       // of its angles about the line of sight
};

class TestDevice {
 public:
  Target target;  // what its yaml says
  Target board;   // what it is: as uneven as boards are taken to be
  CameraRig rig;
  double offset_s;
  Mat3 gyro = Mat3::Identity(), accel = Mat3::Identity();
  Vec3 b_g, b_a;
  ImuNoise noise;

  explicit TestDevice(uint64_t seed) : random_(seed, 1) {
    rig.cameras = 2;
    SE3 nominal;  // B: x forward, y left, z up
    nominal.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    for (int c = 0; c < 2; ++c) {
      Camera& camera = rig.camera[c] = testing::lens(CameraModel::kKannalaBrandt);
      camera.fx *= 1 + uniform(0.01);
      camera.fy = camera.fx * (1 + uniform(0.0005));
      camera.cx += uniform(5), camera.cy += uniform(5);
      for (double& d : camera.d) d += uniform(0.002);
      camera.T_BC.R = nominal.R * so3_exp(M_PI / 180 * vec(1));
      camera.T_BC.p = Vec3(0.02, c == 0 ? 0.0325 : -0.0325, 0.01) + 0.003 * vec(1);
    }
    rig.T_C1C0 = rig.camera[1].T_BC.inverse() * rig.camera[0].T_BC;
    offset_s = 0.017 + uniform(0.002);
    constexpr double kScale = 0.01, kTurned = 0.5 * M_PI / 180;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        gyro(i, j) += uniform(i == j ? kScale : kTurned);
        if (j <= i) accel(i, j) += uniform(i == j ? kScale : kTurned);
      }
    }
    b_g = vec(0.02), b_a = vec(0.2);
    noise.gyro_noise = 1.7e-4, noise.accel_noise = 2e-3;
    noise.gyro_walk = 2e-5, noise.accel_walk = 3e-4;
    noise.rate_hz = 200;
    for (double& phase : phase_) phase = random_.uniform(0, 2 * M_PI);
    board = target;
    for (int tag = 0; tag < target.tags(); ++tag) {
      board.shift_T.push_back(tag_prior_m(target).cwiseProduct(normal()));
    }
  }

  std::vector<Shot> shots(const TestRecording& how) {
    std::vector<Shot> out;
    for (int n = 0; n < int(how.duration_s * how.frames_hz); ++n) {
      const double t_s = kBefore_s + n / how.frames_hz;
      const SE3 T_BT = motion(how, t_s).T_TB.inverse();
      Shot shot;
      shot.t = kStart + from_seconds(t_s - offset_s);
      for (int c = 0; c < 2; ++c) {
        shot.view[c].t = shot.t;
        see(how, rig.camera[c], rig.camera[c].T_BC.inverse() * T_BT, shot.view[c]);
      }
      out.push_back(shot);
    }
    return out;
  }

  // T_C0T at a stamp of the cameras.
  SE3 pose(const TestRecording& how, TimeNs t) const {
    const double t_s = to_seconds(t - kStart) + offset_s;
    return (motion(how, t_s).T_TB * rig.camera[0].T_BC).inverse();
  }

  std::vector<ImuSample> samples(const TestRecording& how) {
    const double root = std::sqrt(how.imu_hz);
    std::vector<ImuSample> out;
    for (int n = 0; n < int((how.duration_s + 2 * kBefore_s) * how.imu_hz); ++n) {
      const Motion at = motion(how, n / how.imu_hz);
      const Vec3 f_B = at.T_TB.R.transpose() * (at.a_T + kGravity_m_s2 * kUp_T);
      ImuSample sample;
      sample.t = kStart + from_seconds(n / how.imu_hz);
      sample.w_B = gyro * at.w_B + b_g + noise.gyro_noise * root * normal();
      sample.f_B = accel * f_B + b_a + noise.accel_noise * root * normal();
      out.push_back(sample);
    }
    return out;
  }

 private:
  static constexpr TimeNs kStart = 1'600'000'000'000'000'000;
  static constexpr double kBefore_s = 0.2;                  // of samples, before and after images
  const Vec3 kUp_T = Vec3(0.03, 0.99, -0.13).normalized();  // the board hangs on a wall, nearly
  struct Motion {
    SE3 T_TB;
    Vec3 w_B, a_T;
  };
  struct Wave {
    double amplitude, hz;
  };

  double uniform(double a) { return random_.uniform(-a, a); }
  Vec3 vec(double a) {
    const double x = uniform(a), y = uniform(a), z = uniform(a);
    return {x, y, z};
  }
  Vec3 normal() {
    const double x = random_.normal(), y = random_.normal(), z = random_.normal();
    return {x, y, z};
  }

  // Value, first and second derivative of axis k: 0..2 angles, 3..5 places.
  Vec3 wave(const TestRecording& how, int k, double t_s) const {
    constexpr Wave kWaves[6][3] = {
        {{0.45, 0.23}, {0.15, 0.71}, {0.05, 1.9}}, {{0.55, 0.19}, {0.15, 0.63}, {0.05, 1.7}},
        {{0.9, 0.13}, {0.25, 0.83}, {0.05, 1.5}},  {{0.22, 0.17}, {0.06, 0.77}, {0.02, 1.6}},
        {{0.18, 0.27}, {0.06, 0.67}, {0.02, 1.8}}, {{0.2, 0.11}, {0.06, 0.73}, {0.02, 1.4}},
    };
    const double share = k == 2 ? how.roll * how.turning : k < 3 ? how.turning : how.moving;
    Vec3 out = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      const double w = 2 * M_PI * kWaves[k][i].hz, a = share * kWaves[k][i].amplitude;
      const double angle = w * t_s + phase_[3 * k + i];
      out += a * Vec3(std::sin(angle), w * std::cos(angle), -w * w * std::sin(angle));
    }
    return out;
  }

  Motion motion(const TestRecording& how, double t_s) const {
    Vec3 phi, phi_dot, p, a;
    for (int k = 0; k < 3; ++k) {
      const Vec3 angle = wave(how, k, t_s), place = wave(how, 3 + k, t_s);
      phi[k] = angle[0], phi_dot[k] = angle[1];
      p[k] = place[0], a[k] = place[2];
    }
    constexpr double kDistance_m = 0.6;
    Mat3 R_TC, R_CB;  // facing the board; the nominal camera in B
    R_TC << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    R_CB << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    Motion out;
    out.T_TB.R = R_TC * so3_exp(phi) * R_CB;
    out.T_TB.p = target.middle_T() + Vec3(0, 0, kDistance_m) + p;
    out.w_B = R_CB.transpose() * right_jacobian(phi) * phi_dot;
    out.a_T = a;
    return out;
  }

  void see(const TestRecording& how, const Camera& camera, const SE3& T_CT, View& out) {
    constexpr double kRim_px = 12;  // a tag nearer to it is cut off
    for (int tag = 0; tag < target.tags(); ++tag) {
      TagImage image;
      if (!project_tag(camera, board, T_CT, tag, image)) continue;
      const double x = random_.normal(), y = random_.normal();
      const Vec2 uv = image.uv + how.tag_px * Vec2(x, y);
      if (camera.in_image(uv, kRim_px)) out.tags.push_back({tag, uv});
    }
  }

  Random random_;
  double phase_[18];
};

}  // namespace pirvs::tools
