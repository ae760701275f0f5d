#include "modules/calibration/calibration_text.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "core/math/so3.h"
#include "modules/calibration/calibration_check.h"

namespace pirvs {
namespace {

Calibration euroc_like() {
  Calibration out;
  for (int c = 0; c < 2; ++c) {
    Camera& camera = out.camera[c];
    camera.width = 752;
    camera.height = 480;
    camera.fx = 458.654;
    camera.fy = 457.296;
    camera.cx = 367.215 + c;
    camera.cy = 248.375;
    camera.d[0] = -0.28340811;
    camera.d[1] = 0.07395907;
    camera.T_BC.R = so3_exp(Vec3(0.01, -0.02, 1.55));
    camera.T_BC.p = Vec3(-0.02, 0.11 * c - 0.06, 1.0 / 3.0);
  }
  out.camera[1].model = CameraModel::kKannalaBrandt;
  out.camera_time_offset_ns = -1'234'567;
  out.imu.gyro_noise = 1.7e-4;
  return out;
}

std::string written(const Calibration& calibration) {
  Text<kCalibrationTextMax> text;
  write_calibration(calibration, text);
  EXPECT_FALSE(text.full());
  return text.c_str();
}

TEST(CalibrationText, TheAntennaMayBeMissing) {
  Calibration in = euroc_like(), out;
  EXPECT_EQ(written(in).find("gnss"), std::string::npos);
  in.gnss = {Vec3(0.1, -1.0 / 3.0, 0.8), -20'000'000};
  ASSERT_FALSE(read_calibration(written(in), out));
  EXPECT_EQ(out.gnss.p_BA, in.gnss.p_BA);
  EXPECT_EQ(out.gnss.time_offset_ns, in.gnss.time_offset_ns);
  EXPECT_FALSE(find_fault(out));
  for (const char* line :
       {"gnss.antenna = 1 2\n", "gnss.time_offset_ns = soon\n", "gnss.x = 1\n"}) {
    EXPECT_TRUE(read_calibration(written(in) + line, out)) << line;
  }
  in.gnss.p_BA.x() = 100;
  EXPECT_STREQ(find_fault(in).where, "gnss");
}

TEST(CalibrationText, ScaleAndBiasOfTheImuMayBeMissing) {
  Calibration in = euroc_like(), out;
  EXPECT_EQ(written(in).find("matrix"), std::string::npos);
  in.imu_intrinsics.gyro(0, 1) = 1.0 / 300;
  in.imu_intrinsics.accel(2, 2) = 1.01;
  in.imu_intrinsics.b_g = Vec3(0.1, -1.0 / 30, 0.02);
  in.imu_intrinsics.b_a = Vec3(0.1, 0.2, -1.0 / 3);
  ASSERT_FALSE(read_calibration(written(in), out));
  EXPECT_EQ(out.imu_intrinsics.gyro, in.imu_intrinsics.gyro);
  EXPECT_EQ(out.imu_intrinsics.accel, in.imu_intrinsics.accel);
  EXPECT_EQ(out.imu_intrinsics.b_g, in.imu_intrinsics.b_g);
  EXPECT_EQ(out.imu_intrinsics.b_a, in.imu_intrinsics.b_a);
  EXPECT_FALSE(find_fault(out));
  for (const char* line : {"imu.gyro_matrix = 1 2\n", "imu.accel_bias = none\n"}) {
    EXPECT_TRUE(read_calibration(written(in) + line, out)) << line;
  }
  in.imu_intrinsics.accel(0, 0) = 9.8;
  EXPECT_STREQ(find_fault(in).where, "imu");
}

TEST(CalibrationText, TheWheelsMayBeMissing) {
  Calibration in = euroc_like(), out;
  EXPECT_EQ(written(in).find("wheels"), std::string::npos);
  in.wheels.known = true;
  in.wheels.T_BV.p = Vec3(-0.2, 0.1, -1.0 / 3.0);
  in.wheels.track_m = 0.41;
  in.wheels.tick_m = 1e-3;
  in.wheels.time_offset_ns = -5'000'000;
  ASSERT_FALSE(read_calibration(written(in), out));
  EXPECT_TRUE(out.wheels.known);
  EXPECT_EQ(out.wheels.T_BV.p, in.wheels.T_BV.p);
  EXPECT_EQ(out.wheels.track_m, 0.41);
  EXPECT_EQ(out.wheels.tick_m, 1e-3);
  EXPECT_EQ(out.wheels.wheelbase_m, 0);
  EXPECT_EQ(out.wheels.time_offset_ns, -5'000'000);
  EXPECT_FALSE(find_fault(out));
  for (const char* line : {"wheels.T_BV = 1 2\n", "wheels.track_m = wide\n", "wheels.x = 1\n"}) {
    EXPECT_TRUE(read_calibration(written(in) + line, out)) << line;
  }
  in.wheels.track_m = 100;
  EXPECT_STREQ(find_fault(in).where, "wheels");
}

TEST(CalibrationText, ReadsWhatItWrote) {
  const Calibration in = euroc_like();
  Calibration out;
  const ConfigFault fault = read_calibration(written(in), out);
  ASSERT_FALSE(fault) << fault.what << ' ' << fault.key;
  EXPECT_EQ(out.cameras, 2);
  EXPECT_EQ(out.camera_time_offset_ns, in.camera_time_offset_ns);
  for (int c = 0; c < 2; ++c) {
    EXPECT_EQ(out.camera[c].model, in.camera[c].model);
    EXPECT_EQ(out.camera[c].width, 752);
    EXPECT_EQ(out.camera[c].height, 480);
    EXPECT_EQ(out.camera[c].fx, in.camera[c].fx);
    EXPECT_EQ(out.camera[c].fy, in.camera[c].fy);
    EXPECT_EQ(out.camera[c].cx, in.camera[c].cx);
    EXPECT_EQ(out.camera[c].d[0], in.camera[c].d[0]);
    EXPECT_EQ(out.camera[c].d[1], in.camera[c].d[1]);
    EXPECT_LT((out.camera[c].T_BC.R - in.camera[c].T_BC.R).cwiseAbs().maxCoeff(), 3e-16);
    EXPECT_LT((out.camera[c].T_BC.p - in.camera[c].T_BC.p).cwiseAbs().maxCoeff(), 1e-16);
  }
  EXPECT_EQ(out.imu.gyro_noise, in.imu.gyro_noise);
  EXPECT_EQ(out.imu.rate_hz, in.imu.rate_hz);
}

TEST(CalibrationText, ARotationOfFewDigitsIsMadeExact) {
  Calibration in = euroc_like(), out;
  Mat3& R = in.camera[0].T_BC.R;
  R = (R * 1e5).array().round().matrix() * 1e-5;
  ASSERT_FALSE(read_calibration(written(in), out));
  const Mat3& exact = out.camera[0].T_BC.R;
  EXPECT_LT((exact * exact.transpose() - Mat3::Identity()).norm(), 4e-15);
  EXPECT_LT((exact - R).norm(), 2e-5);
  R = Mat3::Zero();
  ASSERT_FALSE(read_calibration(written(in), out));
  EXPECT_TRUE(find_fault(out)) << "no rotation at all";
}

TEST(CalibrationText, OneCameraNeedsNoSecond) {
  Calibration in = euroc_like(), out;
  in.cameras = 1;
  EXPECT_FALSE(read_calibration(written(in), out));
  EXPECT_EQ(out.cameras, 1);
  EXPECT_FALSE(find_fault(out));
}

// One line replaced by another, or taken away.
std::string broken(const std::string& from, const std::string& to) {
  std::string text = written(euroc_like());
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  const size_t end = text.find('\n', at);
  return text.replace(at, to.empty() ? end + 1 - at : end - at, to);
}

TEST(CalibrationText, SaysWhatIsWrongAndWhere) {
  struct Broken {
    const char* from;
    const char* to;
    int line;
    const char* what;
  };
  const Broken kBroken[] = {
      {"cameras", "", 0, "a key is missing"},
      {"cameras", "cameras = 3", 1, "there are 1 or 2 cameras"},
      {"camera_time", "camera_time_offset_ns = 0.5", 2, "needs whole nanoseconds, below 1000 s"},
      {"cam0.model", "cam0.model = fisheye", 3, "the models are radtan and equidistant"},
      {"cam0.size", "cam0.size = 752", 4, "needs width and height in pixels"},
      {"cam0.size", "cam0.size = 752 480.5", 4, "needs width and height in pixels"},
      {"cam0.focal", "cam0.focal = 458", 5, "not as many numbers as belong here"},
      {"cam0.T_BC", "cam0.T_BC = 1 0 0 0", 8, "not as many numbers as belong here"},
      {"cam1.centre", "cam1.center = 1 2", 12, "no such key in a calibration"},
      {"cam1.centre", "cam2.centre = 1 2", 12, "no such key in a calibration"},
      {"cam1.distortion", "", 0, "a key of cam1 is missing"},
      {"imu.accel_walk", "imu.accel_walk = nan", 18, "not as many numbers as belong here"},
      {"imu.rate_hz", "", 0, "a key of imu is missing"},
      {"imu.rate_hz", "imu.gyro_noise = 1", 19, "the key stands there twice"},
  };
  for (const Broken& how : kBroken) {
    Calibration out;
    const std::string text = broken(how.from, how.to);
    const ConfigFault fault = read_calibration(text, out);
    ASSERT_TRUE(fault) << how.from << " -> " << how.to;
    EXPECT_EQ(fault.line, how.line) << how.from << " -> " << how.to;
    EXPECT_STREQ(fault.what, how.what) << how.from << " -> " << how.to;
  }
}

}  // namespace
}  // namespace pirvs
