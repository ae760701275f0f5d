// A calibration in flight: whether it still holds, and that the stack uses all of it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <functional>

#include "core/math/so3.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/calib/device_calibration.h"
#include "tools/calib/flight_check.h"
#include "tools/calib/result_files.h"
#include "tools/calib/simulated_device.h"

namespace pirvs::tools {
namespace {

// The clip with the calibration in question.
FlightVerdict check_clip(const std::function<void(Calibration&)>& bump) {
  static const std::vector<FlightLook> looks = follow(*systems::clip());
  Calibration calibration = systems::clip()->calibration;
  bump(calibration);
  const FlightVerdict out = judge(looks, systems::clip()->imu, calibration);
  std::printf("%zu looks, %zu points, %.2f px\n", out.looks, out.points, out.residual_px);
  for (const FlightFinding& f : out.findings) {
    std::printf("  %-42s %8.3f +- %.3f %s%s\n", f.what.c_str(), f.value, f.sigma, f.unit.c_str(),
                f.bumped() ? "  BUMPED" : "");
  }
  return out;
}

TEST(calibration, a_bump_is_seen_in_any_flight) {
  if (systems::clip() == nullptr) GTEST_SKIP() << "the real recording is not on this machine";
  constexpr double kBump_rad = 0.3 * M_PI / 180;
  EXPECT_FALSE(check_clip([](Calibration&) {}).bumped());
  for (int axis = 0; axis < 3; ++axis) {
    const Mat3 turn = so3_exp(kBump_rad * Vec3::Unit(axis));
    EXPECT_TRUE(check_clip([&](Calibration& c) {
                  c.camera[1].T_BC.R = c.camera[1].T_BC.R * turn;
                }).bumped())
        << "right camera, " << axis;
  }
  // Not seen: both cameras turned alike, a focal length that is off by 1 % (docs/calibration.md).
  EXPECT_TRUE(check_clip([](Calibration& c) { c.camera_time_offset_ns += 5'000'000; }).bumped());
}

// What was found is taken out at the door: a flight whose IMU has scale, misalignment and bias.
TEST(calibration, the_stack_takes_the_imus_errors_out) {
  const Recording& ideal = systems::simulated(systems::SimulatedDevice::kIronsides);
  Recording crooked = ideal;
  ImuIntrinsics& found = crooked.calibration.imu_intrinsics;
  found.gyro << 1.01, 0.004, -0.005, 0.003, 0.992, 0.006, -0.004, 0.005, 1.008;
  found.accel << 0.99, 0, 0, 0.006, 1.009, 0, -0.007, 0.005, 1.01;
  found.b_g = Vec3(0.02, -0.03, 0.01);
  found.b_a = Vec3(0.2, -0.1, 0.3);
  for (ImuSample& sample : crooked.imu) {
    sample.w_B = found.gyro * sample.w_B + found.b_g;
    sample.f_B = found.accel * sample.f_B + found.b_a;
  }
  Recording unknown = crooked;
  unknown.calibration.imu_intrinsics = {};
  const systems::Replay was = systems::replay(ideal), with = systems::replay(crooked),
                        without = systems::replay(unknown);
  systems::print("ideal IMU", was);
  systems::print("errors known", with);
  systems::print("errors unknown", without);
  EXPECT_LT(with.result.evaluation.ate_rmse_m, 1.1 * was.result.evaluation.ate_rmse_m);
  // What is not taken out at the door the filter takes for bias: on a short flight its path is as
  // good.
  const auto bias_off_rad_s = [&was](const systems::Replay& run) {
    const auto bias = [](const systems::Replay& r) { return r.log.frames.back().pose.state.b_g; };
    return (bias(run) - bias(was)).norm();
  };
  EXPECT_LT(bias_off_rad_s(with), 0.005);
  EXPECT_GT(bias_off_rad_s(without), 0.02);
}

// With what was found a device flies as well as with the truth; with the drawing's values it does
// not. PIRVS_CALIB_DEVICES=3 for the long run.
TEST(calibration, what_was_found_flies_as_well_as_the_truth) {
  GTEST_SKIP() << "the short recording does not reach the rims of the image yet";
  const char* const more = std::getenv("PIRVS_CALIB_DEVICES");
  const int devices = more != nullptr ? std::atoi(more) : 1;
  double found_m = 0, true_m = 0;
  for (int seed = 1; seed <= devices; ++seed) {
    SimulatedDevice device(static_cast<uint64_t>(seed));
    SimulatedRecording how;
    how.duration_s = more != nullptr ? 60 : 12;
    how.frames_hz = 12;
    CameraOptions options;
    options.model = CameraModel::kKannalaBrandt;
    options.size = {device.rig.camera[0].width, device.rig.camera[0].height};
    ImuCameraOptions motion;
    motion.noise = device.noise;
    const CameraResult cameras = calibrate_cameras(device.target, device.shots(how), 2, options);
    const ImuCameraResult found = calibrate_imu_camera(cameras, device.samples(how), motion);

    const std::string file = systems::scratch_folder("device") + "/calibration.cfg";
    const double offset_s[2] = {device.offset_s, device.offset_s};
    write_device_file(file, device.rig, offset_s, {device.noise, device.imu});
    SimOptions flight;
    flight.device = file;
    flight.seed = static_cast<uint64_t>(100 + seed);
    flight.duration_s = more != nullptr ? 30 : 6;
    flight.rate_hz = more != nullptr ? 30 : 20;
    flight.blur = 2;
    // Biases are those of the calibration, and what they have walked since.
    flight.gyro_bias_rad_s = 1e-3, flight.accel_bias_m_s2 = 1e-2;
    const Recording truth = systems::made(flight, "flight");
    Recording calibrated = truth, nominal = truth;
    for (int c = 0; c < 2; ++c) {
      calibrated.calibration.camera[c] = found.rig.camera[c];
      nominal.calibration.camera[c] = SimulatedDevice::nominal_rig().camera[c];
    }
    calibrated.calibration.camera_time_offset_ns = from_seconds(found.camera[0].offset_s);
    calibrated.calibration.imu_intrinsics = intrinsics_of(found);
    nominal.calibration.camera_time_offset_ns = from_seconds(SimulatedDevice::kNominalOffset_s);
    nominal.calibration.imu_intrinsics = {};
    const systems::Replay with_truth = systems::replay(truth), with = systems::replay(calibrated),
                          without = systems::replay(nominal);
    std::printf("device %d\n", seed);
    systems::print("true calibration", with_truth);
    systems::print("calibration found", with);
    systems::print("nominal calibration", without);
    found_m += with.result.evaluation.ate_rmse_m;
    true_m += with_truth.result.evaluation.ate_rmse_m;
    EXPECT_GT(without.result.evaluation.ate_rmse_m, 1.5 * with_truth.result.evaluation.ate_rmse_m);
  }
  EXPECT_LT(found_m, 1.1 * true_m);
}

}  // namespace
}  // namespace pirvs::tools
