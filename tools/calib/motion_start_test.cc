#include "tools/calib/motion_start.h"

#include <gtest/gtest.h>

#include "core/math/so3.h"
#include "tools/calib/board_scale.h"
#include "tools/calib/simulated_device.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// The board's true poses, with noise of a millimetre and a milliradian.
struct Flight {
  explicit Flight(const SimulatedRecording& how = recording(), uint64_t seed = 1) : device(seed) {
    Random random(seed, 2);
    const auto noise = [&]() -> Vec3 {
      const double x = random.normal(), y = random.normal(), z = random.normal();
      return Vec3(x, y, z) * 1e-3;
    };
    for (const Shot& shot : device.shots(how)) {
      SE3 T_C0T = device.pose(how, shot.t);
      T_C0T.R = T_C0T.R * so3_exp(noise());
      T_C0T.p += noise();
      shots.push_back({shot, T_C0T});
    }
    imu = device.samples(how);
  }
  static SimulatedRecording recording() {
    SimulatedRecording out;
    out.duration_s = 12, out.frames_hz = 12;
    return out;
  }
  std::string refusal() const {
    try {
      (void)start_motion(shots, imu);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  SimulatedDevice device;
  std::vector<PosedShot> shots;
  std::vector<ImuSample> imu;
};

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

TEST(motion_start, finds_rotation_offset_and_gravity) {
  const Flight flight;
  const MotionStart start = start_motion(flight.shots, flight.imu);
  const Mat3& R_BC = flight.device.rig.camera[0].T_BC.R;
  EXPECT_LT(so3_log(R_BC.transpose() * start.R_BC).norm(), 0.03);
  EXPECT_NEAR(start.offset_s, flight.device.offset_s, 2e-3);
  double scale = 0, sigma = 0;
  ASSERT_TRUE(board_scale(flight.shots, flight.imu, start, scale, sigma));
  std::printf("board %.4f of its size, sigma %.4f\n", scale, sigma);
  EXPECT_NEAR(scale, 1, 0.015);  // the accelerometer's own scale is off by up to 1 %
}

TEST(motion_start, refuses_by_name) {
  Flight degrees, in_g, late, still, other, small;
  for (ImuSample& s : degrees.imu) s.w_B *= 180 / M_PI;
  EXPECT_TRUE(has(degrees.refusal(), "degrees per second")) << degrees.refusal();
  for (ImuSample& s : in_g.imu) s.f_B /= 9.81;
  EXPECT_TRUE(has(in_g.refusal(), "in g")) << in_g.refusal();
  for (ImuSample& s : late.imu) s.t += 400'000'000;
  EXPECT_FALSE(late.refusal().empty());
  for (ImuSample& s : other.imu) s.t += 10'000'000'000;  // another part of the flight
  EXPECT_FALSE(other.refusal().empty());
  for (PosedShot& shot : small.shots) shot.T_C0T.p *= 0.9;  // as with tagSize 10 % too small
  EXPECT_TRUE(has(small.refusal(), "of the size that its yaml says")) << small.refusal();
  SimulatedRecording how = Flight::recording();
  how.turning = 0.05;
  EXPECT_TRUE(has(Flight(how).refusal(), "hardly turns"));
}

TEST(motion_start, an_offset_of_80_ms_is_found) {
  Flight flight;
  for (ImuSample& s : flight.imu) s.t += 80'000'000 - from_seconds(flight.device.offset_s);
  EXPECT_NEAR(start_motion(flight.shots, flight.imu).offset_s, 0.08, 2e-3);
}

}  // namespace
}  // namespace pirvs::tools
