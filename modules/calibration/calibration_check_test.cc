#include "modules/calibration/calibration_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "core/math/so3.h"

namespace pirvs {
namespace {

Calibration good() {
  Calibration out;
  for (int c = 0; c < 2; ++c) {
    Camera& camera = out.camera[c];
    camera.width = 752;
    camera.height = 480;
    camera.fx = camera.fy = 458;
    camera.cx = 367;
    camera.cy = 248;
    camera.d[0] = -0.28;
    camera.d[1] = 0.07;
    camera.T_BC.R = so3_exp(Vec3(0, 0, 1.57));
    camera.T_BC.p = camera.T_BC.R * Vec3(0.11 * c, 0, 0);
  }
  return out;
}

TEST(calibration_check, takes_what_cameras_and_imus_are_like) {
  EXPECT_EQ(find_fault(good()).what, nullptr);
  Calibration fisheye = good();
  for (Camera& camera : fisheye.camera) {
    camera.model = CameraModel::kKannalaBrandt;
    camera.width = 640;
    camera.fx = camera.fy = 275;
    camera.cx = 320;
    camera.cy = 240;
    camera.d[0] = 0.01;
    camera.d[1] = -0.002;
  }
  EXPECT_EQ(find_fault(fisheye).what, nullptr);
  Calibration mono = good();
  mono.cameras = 1;
  mono.camera[1] = Camera{};
  EXPECT_EQ(find_fault(mono).what, nullptr);
}

struct Case {
  const char* where;
  const char* says;
  std::function<void(Calibration&)> spoil;
};

TEST(calibration_check, takes_every_shape_that_the_memory_holds) {
  for (const auto& [width, height] : {std::pair{512, 512}, {480, 752}, {1280, 800}, {1024, 1280}}) {
    Calibration c = good();
    for (Camera& camera : c.camera) {
      camera.width = width;
      camera.height = height;
      camera.fx = camera.fy = width;
      camera.cx = width / 2.0;
      camera.cy = height / 2.0;
    }
    EXPECT_FALSE(find_fault(c)) << width << " x " << height << ": " << find_fault(c).what;
  }
}

TEST(calibration_check, says_where_it_is_wrong) {
  const Case cases[] = {
      {"cam0", "larger", [](Calibration& c) { c.camera[0].width = 4096; }},
      {"cam1", "larger", [](Calibration& c) { c.camera[1].height = 1281; }},
      {"cam0", "larger", [](Calibration& c) { c.camera[0].width = c.camera[0].height = 1280; }},
      {"cam1", "no size", [](Calibration& c) { c.camera[1].height = 0; }},
      {"cam0", "finite", [](Calibration& c) { c.camera[0].d[2] = NAN; }},
      {"cam1", "finite", [](Calibration& c) { c.camera[1].T_BC.p.x() = INFINITY; }},
      {"cam1", "rotation", [](Calibration& c) { c.camera[1].T_BC.R *= 1.01; }},
      {"cam0", "rotation", [](Calibration& c) { c.camera[0].T_BC.R.col(0) *= -1; }},
      {"cam0", "5 m", [](Calibration& c) { c.camera[0].T_BC.p.x() = 110; }},
      {"cam0", "focal", [](Calibration& c) { c.camera[0].fx = 4; }},
      {"cam1", "focal", [](Calibration& c) { c.camera[1].fy = 2000; }},
      {"cam0", "focal", [](Calibration& c) { c.camera[0].fx = NAN; }},
      {"cam0", "principal", [](Calibration& c) { c.camera[0].cx = 800; }},
      {"cam1", "principal", [](Calibration& c) { c.camera[1].cy = -3; }},
      {"cam0", "turns back", [](Calibration& c) { c.camera[0].d[0] = -2.8; }},
      {"imu", "gyro's noise", [](Calibration& c) { c.imu.gyro_noise = 1.7e-8; }},
      {"imu", "gyro's random", [](Calibration& c) { c.imu.gyro_walk = 2; }},
      {"imu", "accelerometer's noise", [](Calibration& c) { c.imu.accel_noise = NAN; }},
      {"imu", "accelerometer's random", [](Calibration& c) { c.imu.accel_walk = -1; }},
      {"imu", "rate", [](Calibration& c) { c.imu.rate_hz = 0.005; }},
      {"cameras", "time offset", [](Calibration& c) { c.camera_time_offset_ns = 4'000'000'000; }},
      {"cameras", "baseline", [](Calibration& c) { c.camera[1].T_BC.p.setZero(); }},
      {"cameras", "left of", [](Calibration& c) { std::swap(c.camera[0], c.camera[1]); }},
      {"cameras", "apart", [](Calibration& c) { c.camera[1].T_BC.R *= so3_exp(Vec3(0, 1.6, 0)); }},
  };
  for (const Case& spoiled : cases) {
    Calibration calibration = good();
    spoiled.spoil(calibration);
    const CalibrationFault fault = find_fault(calibration);
    ASSERT_NE(fault.what, nullptr) << spoiled.says;
    EXPECT_EQ(std::string(fault.where), spoiled.where) << fault.what;
    EXPECT_NE(std::string(fault.what).find(spoiled.says), std::string::npos) << fault.what;
    EXPECT_STRNE(fault.what_to_do, "");
  }
}

}  // namespace
}  // namespace pirvs
