// What devices bring from the factory: DepthAI's EEPROM, what a RealSense prints.
#include <gtest/gtest.h>

#include <algorithm>

#include "tools/dataset/calibration/rig_file.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/test_recording.h"

namespace pirvs::tools {
namespace {

class factory_file : public testing::Test {
 protected:
  std::string write(const std::string& text) const {
    disk.write("factory", text);
    return disk.path("factory");
  }
  RigFile read(const std::string& text) const { return read_rig_file(write(text)); }
  Rig rig(const std::string& text, int width, int height) {
    RigOptions options;
    options.image_size = [=] { return std::pair(width, height); };
    log = {};
    return read_rig(write(text), options, log);
  }
  template <class Read>
  static std::string refusal(Read&& of) {
    try {
      of();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  std::string refusal_of(const std::string& text) const {
    return refusal([&] { read(text); });
  }
  static void expect_has(const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
  // The left camera looks along x of the IMU, its x is -y, its y is -z; the right one 0.1 m along
  // its x.
  static void expect_pair(const RigFile& rig) {
    ASSERT_GE(rig.cameras.size(), 2u);
    const SE3& T_BC = rig.cameras[0].T_BC;
    EXPECT_LT((T_BC.p - Vec3(0.02, 0.05, -0.03)).norm(), 1e-9);
    EXPECT_LT((T_BC.R * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-9);
    EXPECT_LT((T_BC.R * Vec3::UnitX() + Vec3::UnitY()).norm(), 1e-9);
    const Vec3 p_C0C1 = (T_BC.inverse() * rig.cameras[1].T_BC).p;
    EXPECT_LT((p_C0C1 - Vec3(0.1, 0, 0)).norm(), 1e-9);
  }
  bool noted(const char* part) const {
    return std::any_of(log.notes.begin(), log.notes.end(), [&](const std::string& note) {
      return note.find(part) != std::string::npos;
    });
  }
  TestRecording disk;
  InputLog log;
};

// ---- DepthAI -----------------------------------------------------------------------------------
constexpr const char* kNoRotation = "[[0,0,0],[0,0,0],[0,0,0]]";
// p_left = R p_imu + t: the inverse of the pose that is expected.
constexpr const char* kImuRotation = "[[0,-1,0],[0,0,-1],[1,0,0]]";
constexpr const char* kNoLens = "[0,0,0,0,0,0,0,0,0,0,0,0,0,0]";

struct Eeprom {
  const char* imu_R = kImuRotation;
  const char* distortion = kNoLens;
  const char* type = "0";
  int width = 1280, height = 800;
  const char* sockets = "\"leftCameraSocket\":1,\"rightCameraSocket\":2";
  int right = 2;  // its number
};

// In cm, each camera against another one: the right one and the IMU stand by the left one.
std::string depthai(const Eeprom& e) {
  const auto camera = [&](int socket, int to, const char* x) {
    return "[" + std::to_string(socket) + ",{\"cameraType\":" + e.type +
           ",\"width\":" + std::to_string(e.width) + ",\"height\":" + std::to_string(e.height) +
           ",\"intrinsicMatrix\":[[800,0,640.5],[0,801,400.25],[0,0,1]],\"distortionCoeff\":" +
           e.distortion +
           ",\"extrinsics\":{\"rotationMatrix\":" + (to < 0 ? "[]" : "[[1,0,0],[0,1,0],[0,0,1]]") +
           ",\"specTranslation\":{\"x\":" + x +
           ",\"y\":0,\"z\":0},\"toCameraSocket\":" + std::to_string(to) +
           ",\"translation\":{\"x\":" + x + ",\"y\":0,\"z\":0}}}]";
  };
  return "{\"boardName\":\"DM9098\",\"cameraData\":[" + camera(0, -1, "0") + "," +
         camera(1, e.right, "-10") + "," + camera(e.right, 0, "5") +
         "],\"stereoRectificationData\":{" + e.sockets +
         "},\"imuExtrinsics\":{\"rotationMatrix\":" + e.imu_R +
         ",\"toCameraSocket\":1,\"translation\":{\"x\":5,\"y\":-3,\"z\":-2}}}";
}

TEST_F(factory_file, depthai_chains_cameras) {
  const RigFile oak = read(depthai({}));
  expect_pair(oak);
  EXPECT_EQ(oak.cameras[1].lens.fy, 801);
  EXPECT_EQ(oak.cameras[1].lens.cx, 640.5);
  EXPECT_EQ(oak.cameras[1].lens.distortion, Distortion::kNone);
  // A board that names no pair, -1 in a byte or not.
  Eeprom unset;
  unset.sockets = "\"leftCameraSocket\":255,\"rightCameraSocket\":-1";
  expect_pair(read(depthai(unset)));
}

TEST_F(factory_file, depthai_has_two_kinds_of_lenses) {
  Eeprom eeprom;
  eeprom.distortion = "[1,2,3,4,5,6,7,8,9,10,11,12,0.125,0.25]";
  const Lens rational = read(depthai(eeprom)).cameras[0].lens;
  EXPECT_EQ(rational.distortion, Distortion::kRadtan);
  for (size_t i = 0; i < 12; ++i) EXPECT_EQ(rational.d[i], double(i + 1));
  EXPECT_EQ(rational.d[12], 0.125);
  EXPECT_EQ(rational.d[13], 0.25);
  eeprom.type = "1";
  const Lens fisheye = read(depthai(eeprom)).cameras[0].lens;
  EXPECT_EQ(fisheye.distortion, Distortion::kEquidistant);
  EXPECT_EQ(fisheye.d[3], 4);
  EXPECT_EQ(fisheye.d[4], 0);
  eeprom.type = "2";
  expect_has(refusal_of(depthai(eeprom)), "unknown camera type");
}

// 1280 x 800 of the sensor: halved, a strip of it, or as it is.
TEST_F(factory_file, depthai_scales_and_crops) {
  const Camera half = rig(depthai({}), 640, 400).calibration.camera[0];
  EXPECT_EQ(half.width, 640);
  EXPECT_DOUBLE_EQ(half.fx, 400);
  EXPECT_DOUBLE_EQ(half.cx, 320);      // (640.5 + 0.5) / 2 - 0.5
  EXPECT_DOUBLE_EQ(half.cy, 199.875);  // (400.25 + 0.5) / 2 - 0.5
  const Camera strip = rig(depthai({}), 1280, 720).calibration.camera[1];
  EXPECT_DOUBLE_EQ(strip.fy, 801);
  EXPECT_DOUBLE_EQ(strip.cx, 640.5);
  EXPECT_DOUBLE_EQ(strip.cy, 360.25);
  EXPECT_EQ(rig(depthai({}), 1280, 800).calibration.camera[0].cy, 400.25);
  // Exchanged it is left alone: the player says so.
  EXPECT_EQ(rig(depthai({}), 800, 1280).calibration.camera[0].width, 1280);
}

TEST_F(factory_file, depthai_without_noise_takes_the_usual_and_says_so) {
  EXPECT_EQ(rig(depthai({}), 1280, 800).calibration.imu.gyro_noise, 4.9e-4);
  EXPECT_TRUE(noted("BMI270")) << log.notes.at(0);
  disk.write("imu.yaml", disk.read("imu0/sensor.yaml"));
  EXPECT_EQ(rig(depthai({}), 1280, 800).calibration.imu.gyro_noise, 1.0e-4);
  EXPECT_FALSE(noted("BMI270"));
}

TEST_F(factory_file, bad_depthai_is_told) {
  Eeprom no_imu, no_right, no_size;
  no_imu.imu_R = kNoRotation;
  expect_has(refusal_of(depthai(no_imu)), "no extrinsics here");
  no_right.right = 4;
  expect_has(refusal_of(depthai(no_right)), "no camera at the stereo pair's socket 2");
  no_size.width = 0;
  expect_has(refusal_of(depthai(no_size)), "needs width and height");
  const std::string whole = depthai({});
  expect_has(refusal_of(whole.substr(0, whole.size() / 2)), "not JSON, or cut off");
}

// ---- RealSense ---------------------------------------------------------------------------------
std::string lens_text(const char* name, int width, int height, const char* fx, const char* model,
                      const char* d) {
  const std::string w = std::to_string(width), h = std::to_string(height);
  return " Intrinsic of \"" + std::string(name) + "\" / " + w + "x" + h +
         " / {Y8}\n  Width:      \t" + w + "\n  Height:     \t" + h +
         "\n  PPX:        \t419.25\n  PPY:        \t386.5\n  Fx:         \t" + fx +
         "\n  Fy:         \t287.5\n  Distortion: \t" + model + "\n  Coeffs:     \t" + d +
         "\n  FOV (deg):  \t111.92 x 108.66\n\n";
}
std::string extrinsic_text(const char* from, const char* to, const char* R, const char* t) {
  return "Extrinsic from \"" + std::string(from) + "\"\t  To\t  \"" + to +
         "\" :\n Rotation Matrix:\n" + R + "\n Translation Vector: " + t + "  \n\n";
}
constexpr const char* kToImu = "   0           0           1\n  -1   0   0\n   0  -1   0\n";
constexpr const char* kFromImu = "   0  -1   0\n   0   0  -1\n   1   0   0\n";

const std::string kHead =
    "Device info: \n    Name                          : \tIntel RealSense T265\n\n"
    "Stream Profiles supported by Tracking Module\n Supported modes:\n"
    "    Fisheye 1\t  848x800\t@ 30Hz\t   Y8\n    Gyro\t N/A\t\t@ 200Hz\t   MOTION_XYZ32F\n\n"
    "Intrinsic Parameters:\n\n";
const std::string kMotion =
    "Motion Intrinsic Parameters:\n\nMotion Intrinsic of \"Gyro\"\t  MOTION_XYZ32F\n"
    "Bias Variances: \t0.000000499999999  0.000000499999999  0.000000499999999  \n"
    "Noise Variances: \t0.000005148030141  0.000005148030141  0.000005148030141  \n"
    "Sensitivity : \n     1.000000       0.000000       0.000000       0.000000  \n"
    "     0.000000       1.000000       0.000000       0.000000  \n"
    "     0.000000       0.000000       SCALE       0.000000  \n\n\n";
std::string motion(const char* scale) {
  std::string out = kMotion;
  return out.replace(out.find("SCALE"), 5, scale);
}

std::string t265(const char* scale = "0.997373") {
  const char* const kb = "Kannala Brandt4";
  return kHead +
         lens_text("Fisheye 1", 848, 800, "286.25", kb, "-0.5  \t0.25  \t-0.125  \t0.0625  \t0  ") +
         lens_text("Fisheye 2", 848, 800, "285.25", kb,
                   "-0.5  \t0.25  \t-0.125  \t0.03125  \t0  ") +
         motion(scale) + "\nExtrinsic Parameters:\n" +
         extrinsic_text("Fisheye 1", "Gyro", kToImu, "0.02  0.05  -0.03") +
         // The inverse of (R, (0.02, -0.05, -0.03)).
         extrinsic_text("Gyro", "Fisheye 2", kFromImu, "-0.05  -0.03  -0.02") +
         "Extrinsic from \"Fisheye 1\"\t  To\t  \"Pose\" :\nN/A\n";
}

// The factory's infrared images are rectified; each size has a lens.
std::string d435i() {
  const char* const none = "0  \t0  \t0  \t0  \t0  ";
  std::string out = kHead;
  for (const char* name : {"Infrared 1", "Infrared 2"}) {
    out += " Intrinsic of \"" + std::string(name) +
           "\" / 1280x800 / {Y16}\nIntrinsic NOT available!\n\n";
    out += lens_text(name, 640, 480, "382.5", "Brown Conrady", none);
    out += lens_text(name, 848, 480, "422.75", "Brown Conrady", none);
  }
  out += lens_text("Color", 640, 480, "600", "Inverse Brown Conrady", none);
  out += motion("1.000000") + "\nExtrinsic Parameters:\n";
  const char* const one = "   1   0   0\n   0   1   0\n   0   0   1\n";
  // As a D435i's, p_gyro = p_camera + t; the right camera 50 mm to the right.
  out += extrinsic_text("Infrared 1", "Gyro", one, "-0.00552  0.0051  0.01174");
  out += extrinsic_text("Infrared 2", "Gyro", one, "0.04448  0.0051  0.01174");
  out += extrinsic_text("Color", "Gyro", one, "0.00948  0.0051  0.01174");
  return out;
}

TEST_F(factory_file, t265_is_equidistant) {
  const RigFile rig = read(t265());
  expect_pair(rig);
  ASSERT_EQ(rig.cameras.size(), 2u);
  const Lens& lens = rig.cameras[1].lens;
  EXPECT_EQ(lens.width, 848);
  EXPECT_EQ(lens.height, 800);
  EXPECT_EQ(lens.fx, 285.25);
  EXPECT_EQ(lens.fy, 287.5);
  EXPECT_EQ(lens.cx, 419.25);
  EXPECT_EQ(lens.cy, 386.5);
  EXPECT_EQ(lens.distortion, Distortion::kEquidistant);
  EXPECT_EQ(lens.d[0], -0.5);
  EXPECT_EQ(lens.d[3], 0.03125);
  EXPECT_EQ(rig.notes.size(), 1u);
  EXPECT_TRUE(read(t265("1.000000")).notes.empty());
}

TEST_F(factory_file, d435i_has_a_lens_for_each_size) {
  const Rig vga = rig(d435i(), 640, 480), wide = rig(d435i(), 848, 480);
  EXPECT_EQ(vga.calibration.camera[1].fx, 382.5);
  EXPECT_EQ(wide.calibration.camera[1].fx, 422.75);
  EXPECT_EQ(wide.calibration.camera[1].width, 848);
  EXPECT_EQ(wide.calibration.camera[0].d[0], 0);
  const SE3& T_BC = wide.calibration.camera[0].T_BC;
  EXPECT_LT((T_BC.p - Vec3(-0.00552, 0.0051, 0.01174)).norm(), 1e-12);
  EXPECT_LT((wide.calibration.camera[1].T_BC.p - T_BC.p - Vec3(0.05, 0, 0)).norm(), 1e-12);
  EXPECT_TRUE(noted("BMI055"));
  EXPECT_EQ(wide.calibration.imu.accel_noise, 3.1e-3);
  EXPECT_EQ(read(d435i()).cameras.size(), 3u);
}

TEST_F(factory_file, bad_realsense_is_told) {
  const auto at_size = [&](int width, int height) {
    return refusal([&] { rig(d435i(), width, height); });
  };
  expect_has(at_size(640, 400), "no lens for images of 640 x 400");
  expect_has(at_size(480, 640), "width and height are exchanged");
  expect_has(refusal([&] {
               InputLog none;
               read_rig(write(d435i()), {}, none);
             }),
             "--size");
  const auto without = [](std::string text, const std::string& from, const std::string& to) {
    for (size_t at; (at = text.find(from)) != std::string::npos;) text.replace(at, from.size(), to);
    return text;
  };
  const std::string whole = t265();
  expect_has(refusal_of(without(whole, "Fisheye 2", "Fisheye 3")), "no lens of \"Fisheye 2\"");
  expect_has(refusal_of(without(whole, "Gyro", "Pose")), "no extrinsic of \"Fisheye 1\"");
  expect_has(refusal_of(without(whole, "Kannala Brandt4", "Inverse Brown Conrady")),
             "'Inverse Brown Conrady' is not computed here");
  expect_has(refusal_of(without(whole, "   0  -1   0\n\n", "   0  -2   0\n\n")), "not a rotation");
  expect_has(refusal_of(whole + whole), "several devices");
  // Cut off at any line, it is told, or what it says so far is a whole rig.
  const size_t needed = whole.find("Extrinsic from \"Fisheye 1\"\t  To\t  \"Pose\"");
  for (size_t at = whole.find("Width"); at < needed; at = whole.find('\n', at + 1)) {
    const std::string said = refusal_of(whole.substr(0, at));
    if (at + 4 < needed) EXPECT_FALSE(said.empty()) << at << " of " << needed;
  }
}

}  // namespace
}  // namespace pirvs::tools
