#include "tools/dataset/calibration/rig_file.h"

#include <gtest/gtest.h>

#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/test_recording.h"

namespace pirvs::tools {
namespace {

// T_imu_cam of all files below: the camera looks along x of the IMU, its x is -y, its y is -z.
constexpr const char* kRows = "[0, 0, 1, 0.02], [-1, 0, 0, 0.05], [0, -1, 0, -0.03], [0, 0, 0, 1]";
constexpr const char* kFlat = "0, 0, 1, 0.02, -1, 0, 0, 0.05, 0, -1, 0, -0.03, 0, 0, 0, 1";
// Its inverse, by hand: R' and -R' p.
constexpr const char* kInverse = "0, -1, 0, 0.05, 0, 0, -1, -0.03, 1, 0, 0, -0.02, 0, 0, 0, 1";
// Of the right camera, 0.1 m along the left one's x, which is -y of the IMU.
constexpr const char* kRight = "0, 0, 1, 0.02, -1, 0, 0, -0.05, 0, -1, 0, -0.03, 0, 0, 0, 1";

std::string matrix(const char* numbers) {
  return "!!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: [" + std::string(numbers) +
         "]\n";
}

class rig_file : public testing::Test {
 protected:
  RigFile read(const std::string& text, const std::string& name = "rig.yaml") const {
    disk.write(name, text);
    return read_rig_file(disk.path(name));
  }
  std::string refusal(const std::string& text) const {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  static void expect_left(const RigCamera& camera) {
    EXPECT_LT((camera.T_BC.p - Vec3(0.02, 0.05, -0.03)).norm(), 1e-12);
    EXPECT_LT((camera.T_BC.R * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-12);
    EXPECT_LT((camera.T_BC.R * Vec3::UnitX() + Vec3::UnitY()).norm(), 1e-12);
  }
  static void expect_pair(const RigFile& rig) {
    ASSERT_EQ(rig.cameras.size(), 2u);
    expect_left(rig.cameras[0]);
    const Vec3 p_C0C1 = (rig.cameras[0].T_BC.inverse() * rig.cameras[1].T_BC).p;
    EXPECT_LT((p_C0C1 - Vec3(0.1, 0, 0)).norm(), 1e-12);
  }
  static void expect_noise(const RigFile& rig) {
    ASSERT_TRUE(rig.imu.has_value());
    EXPECT_EQ(rig.imu->noise.gyro_noise, 1.6e-4);
    EXPECT_EQ(rig.imu->noise.gyro_walk, 2.2e-5);
    EXPECT_EQ(rig.imu->noise.accel_noise, 2.8e-3);
    EXPECT_EQ(rig.imu->noise.accel_walk, 8.6e-4);
  }
  TestRecording disk;
};

std::string kalibr_camera(const std::string& pose, const std::string& model = "pinhole",
                          const std::string& k = "400, 401, 320, 240",
                          const std::string& distortion = "radtan",
                          const std::string& d = "0.1, 0.2, 0.003, 0.004") {
  return "  " + pose + "\n  camera_model: " + model + "\n  intrinsics: [" + k +
         "]\n  distortion_model: " + distortion + "\n  distortion_coeffs: [" + d +
         "]\n  resolution: [640, 480]\n";
}
std::string imu(const std::string& indent) {
  return indent + "gyroscope_noise_density: 0.00016\n" + indent +
         "gyroscope_random_walk: 2.2e-05\n" + indent + "accelerometer_noise_density: 0.0028\n" +
         indent + "accelerometer_random_walk: 0.00086\n" + indent + "update_rate: 200.0\n";
}

TEST_F(rig_file, kalibr_has_poses_in_four_forms) {
  const std::string forms[] = {"T_imu_cam: [" + std::string(kRows) + "]",
                               "T_imu_cam: [" + std::string(kFlat) + "]",
                               "T_cam_imu: [" + std::string(kInverse) + "]",
                               "T_cam_imu:\n  - [0, -1, 0, 0.05]\n  - [0, 0, -1, -0.03]\n"
                               "  - [1, 0, 0, -0.02]\n  - [0, 0, 0, 1]"};
  for (const std::string& form : forms) {
    const RigFile rig =
        read("%YAML:1.0\ncam0:\n" + kalibr_camera(form) + "  timeshift_cam_imu: 0.0034\ncam1:\n" +
             kalibr_camera("T_cn_cnm1: [1,0,0,-0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1]") +
             "  timeshift_cam_imu: -0.0106\nimu0:\n" + imu("  "));
    expect_pair(rig);
    expect_noise(rig);
    EXPECT_EQ(rig.cameras[0].shift_ns, 3'400'000);
    EXPECT_EQ(rig.cameras[1].shift_ns, -10'600'000);
    EXPECT_EQ(rig.cameras[0].lens.d[3], 0.004);
  }
}

TEST_F(rig_file, kalibr_has_six_models) {
  struct Case {
    const char *model, *k, *distortion, *d;
    Projection projection;
    Distortion found;
    double a, b;
  };
  const Case cases[] = {
      {"pinhole", "400, 401, 320, 240", "none", "", Projection::kPinhole, Distortion::kNone, 0, 0},
      {"pinhole", "400, 401, 320, 240", "plumb_bob", "0, 0, 0, 0, 0", Projection::kPinhole,
       Distortion::kNone, 0, 0},
      {"pinhole", "400, 401, 320, 240", "radtan", "1, 2, 3, 4, 5", Projection::kPinhole,
       Distortion::kRadtan, 0, 0},
      {"pinhole", "400, 401, 320, 240", "equidistant", "1, 2, 3, 4", Projection::kPinhole,
       Distortion::kEquidistant, 0, 0},
      {"pinhole", "400, 401, 320, 240", "fov", "0.9", Projection::kPinhole, Distortion::kFov, 0, 0},
      {"omni", "1.5, 400, 401, 320, 240", "radtan", "1, 2, 3, 4", Projection::kOmni,
       Distortion::kRadtan, 1.5, 0},
      {"ds", "-0.2, 0.6, 400, 401, 320, 240", "none", "", Projection::kDoubleSphere,
       Distortion::kNone, -0.2, 0.6},
      {"eucm", "0.6, 1.1, 400, 401, 320, 240", "none", "", Projection::kEucm, Distortion::kNone,
       0.6, 1.1}};
  const std::string pose = "T_imu_cam: [" + std::string(kFlat) + "]";
  for (const Case& c : cases) {
    const RigFile rig = read("cam0:\n" + kalibr_camera(pose, c.model, c.k, c.distortion, c.d));
    const Lens& lens = rig.cameras.at(0).lens;
    EXPECT_EQ(lens.projection, c.projection) << c.model;
    EXPECT_EQ(lens.distortion, c.found) << c.model << " " << c.distortion;
    EXPECT_EQ(lens.a, c.a);
    EXPECT_EQ(lens.b, c.b);
    EXPECT_EQ(lens.fy, 401);
    EXPECT_EQ(lens.cx, 320);
    EXPECT_FALSE(rig.imu.has_value());
  }
}

TEST_F(rig_file, openvins_names_other_files) {
  disk.write("chain.yaml", "cam0:\n" + kalibr_camera("T_imu_cam: [" + std::string(kFlat) + "]") +
                               "cam1:\n" +
                               kalibr_camera("T_imu_cam: [" + std::string(kRight) + "]"));
  disk.write("imu_chain.yaml", "imu0:\n" + imu("  "));
  const std::string text =
      "%YAML:1.0\nverbosity: \"INFO\"\ngravity_mag: 9.81\nrelative_config_imu: imu_chain.yaml\n"
      "relative_config_imucam: \"chain.yaml\"\n";
  expect_pair(read(text));
  expect_noise(read(text));
  EXPECT_EQ(read(text + "max_cameras: 1\n").cameras.size(), 1u);
}

TEST_F(rig_file, basalt_is_json) {
  const auto text = [](const char* lens) {
    const std::string q = "\"qx\":-0.5,\"qy\":0.5,\"qz\":-0.5,\"qw\":0.5";
    const std::string camera = "{\"camera_type\":" + std::string(lens) + "}";
    return "{\"value0\":{\"T_imu_cam\":[{\"px\":0.02,\"py\":0.05,\"pz\":-0.03," + q +
           "},{\"px\":0.02,\"py\":-0.05,\"pz\":-0.03," + q + "}],\"intrinsics\":[" + camera + "," +
           camera +
           "],\"resolution\":[[640,480],[640,480]],\"imu_update_rate\":200.0,"
           "\"accel_noise_std\":[0.0028,0.0028,0.0028],\"gyro_noise_std\":[0.00016,0.00016,0.00016]"
           ","
           "\"accel_bias_std\":[0.00086,0.00086,0.00086],\"gyro_bias_std\":[2.2e-5,2.2e-5,2.2e-5],"
           "\"cam_time_offset_ns\":1500}}";
  };
  const RigFile ds =
      read(text("\"ds\",\"intrinsics\":{\"fx\":1,\"fy\":2,\"cx\":3,\"cy\":4,"
                "\"xi\":-0.2,\"alpha\":0.6}"));
  expect_pair(ds);
  expect_noise(ds);
  EXPECT_EQ(ds.cameras[1].lens.projection, Projection::kDoubleSphere);
  EXPECT_EQ(ds.cameras[1].lens.b, 0.6);
  EXPECT_EQ(ds.cameras[1].shift_ns, 1500);
  const RigFile kb4 =
      read(text("\"kb4\",\"intrinsics\":{\"fx\":1,\"fy\":2,\"cx\":3,\"cy\":4,"
                "\"k1\":0.1,\"k2\":0.2,\"k3\":0.3,\"k4\":0.4}"));
  EXPECT_EQ(kb4.cameras[0].lens.distortion, Distortion::kEquidistant);
  EXPECT_EQ(kb4.cameras[0].lens.d[3], 0.4);
  const std::string k = "\"intrinsics\":{\"fx\":1,\"fy\":2,\"cx\":3,\"cy\":4";
  const auto lens = [&](const std::string& type, const std::string& more) {
    return read(text(("\"" + type + "\"," + k + more + "}").c_str())).cameras.at(1).lens;
  };
  const Lens eucm = lens("eucm", ",\"alpha\":0.6,\"beta\":1.1"),
             ucm = lens("ucm", ",\"alpha\":0.6");
  EXPECT_EQ(eucm.projection, Projection::kEucm);
  EXPECT_EQ(eucm.b, 1.1);
  EXPECT_EQ(ucm.a, 0.6);
  EXPECT_EQ(ucm.b, 1);
  EXPECT_EQ(lens("pinhole", "").distortion, Distortion::kNone);
  const Lens rational = lens("pinhole-radtan8",
                             ",\"k1\":1,\"k2\":2,\"p1\":3,\"p2\":4,\"k3\":5,\"k4\":6,\"k5\":7,"
                             "\"k6\":8,\"rpmax\":9");
  for (size_t i = 0; i < 8; ++i) EXPECT_EQ(rational.d[i], double(i + 1));
  EXPECT_EQ(rational.cy, 4);
}

TEST_F(rig_file, orbslam_stands_by_its_left_camera) {
  const std::string camera1 =
      "Camera1.fx: 400.0\nCamera1.fy: 401.0\nCamera1.cx: 320.0\nCamera1.cy: 240.0\n"
      "Camera1.k1: 0.1\nCamera1.k2: 0.2\n";
  const std::string rest =
      "Camera.width: 640\nCamera.height: 480\nCamera.fps: 20\nIMU.T_b_c1: " + matrix(kFlat) +
      "IMU.NoiseGyro: 1.6e-4\nIMU.NoiseAcc: 2.8e-3\nIMU.GyroWalk: 2.2e-5\n"
      "IMU.AccWalk: 8.6e-4\nIMU.Frequency: 200\n";
  const std::string stereo =
      "Camera2.fx: 402.0\nCamera2.fy: 403.0\nCamera2.cx: 320.0\n"
      "Camera2.cy: 240.0\nCamera2.k1: 0.3\nStereo.T_c1_c2: " +
      matrix("1,0,0,0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1");
  const RigFile pinhole = read("%YAML:1.0\n---\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\n" +
                               camera1 + "Camera1.p1: 0.003\nCamera1.p2: 0.004\n" + rest + stereo);
  expect_pair(pinhole);
  expect_noise(pinhole);
  EXPECT_EQ(pinhole.cameras[0].lens.d[2], 0.003);
  EXPECT_EQ(pinhole.cameras[1].lens.fx, 402);
  const RigFile fisheye = read("%YAML:1.0\nCamera.type: \"KannalaBrandt8\"\n" + camera1 +
                               "Camera1.k3: 0.3\nCamera1.k4: 0.4\n" + rest);
  ASSERT_EQ(fisheye.cameras.size(), 1u);
  EXPECT_EQ(fisheye.cameras[0].lens.d[3], 0.4);
  const RigFile rectified =
      read("%YAML:1.0\nCamera.type: \"Rectified\"\nStereo.b: 0.1\n" + camera1 + rest);
  expect_pair(rectified);
  EXPECT_EQ(rectified.cameras[1].lens.distortion, Distortion::kNone);
  EXPECT_NE(refusal("Camera.type: \"PinHole\"\nCamera.fx: 400\n").find("before 1.0"),
            std::string::npos);
}

TEST_F(rig_file, vins_names_its_cameras) {
  disk.write(
      "left.yaml",
      "%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: camera\nimage_width: 640\n"
      "image_height: 480\ndistortion_parameters:\n   k1: 0.1\n   k2: 0.2\n   p1: 0.003\n"
      "   p2: 0.004\nprojection_parameters:\n   fx: 400\n   fy: 401\n   cx: 320\n   cy: 240\n");
  disk.write("right.yaml",
             "%YAML:1.0\n---\nmodel_type: MEI\nimage_width: 640\nimage_height: 480\n"
             "mirror_parameters:\n   xi: 1.5\ndistortion_parameters:\n   k1: 0.1\n   k2: 0.2\n"
             "   p1: 0.003\n   p2: 0.004\nprojection_parameters:\n   gamma1: 700\n   gamma2: 701\n"
             "   u0: 320\n   v0: 240\n");
  const std::string noise = "acc_n: 0.0028\ngyr_n: 0.00016\nacc_w: 0.00086\ngyr_w: 2.2e-05\n";
  const RigFile rig = read(
      "%YAML:1.0\nimu: 1\nnum_of_cam: 2\ncam0_calib: \"left.yaml\"\n"
      "cam1_calib: \"right.yaml\"\nbody_T_cam0: " +
      matrix(kFlat) + "body_T_cam1: " + matrix(kRight) + noise + "td: -0.005\n");
  expect_pair(rig);
  expect_noise(rig);
  EXPECT_FALSE(rig.imu->has_rate);
  EXPECT_EQ(rig.cameras[1].shift_ns, -5'000'000);
  EXPECT_EQ(rig.cameras[1].lens.projection, Projection::kOmni);
  EXPECT_EQ(rig.cameras[1].lens.a, 1.5);
  const RigFile mono = read(
      "%YAML:1.0\nmodel_type: KANNALA_BRANDT\nimage_width: 640\nimage_height: 480\n"
      "projection_parameters:\n   k2: 0.1\n   k3: 0.2\n   k4: 0.3\n   k5: 0.4\n   mu: 200\n"
      "   mv: 201\n   u0: 320\n   v0: 240\nextrinsicRotation: !!opencv-matrix\n   rows: 3\n"
      "   cols: 3\n   dt: d\n   data: [0,0,1, -1,0,0, 0,-1,0]\nextrinsicTranslation: "
      "!!opencv-matrix\n"
      "   rows: 3\n   cols: 1\n   dt: d\n   data: [0.02, 0.05, -0.03]\n" +
      noise);
  expect_left(mono.cameras.at(0));
  EXPECT_EQ(mono.cameras[0].lens.d[0], 0.1);
}

TEST_F(rig_file, okvis_delays_images) {
  const auto camera = [](const char* T, const char* type, const char* d) {
    return "    - {T_SC: [" + std::string(T) +
           "],\n       image_dimension: [640, 480],\n"
           "       distortion_coefficients: [" +
           d + "],\n       distortion_type: " + type +
           ",\n       focal_length: [400, 401],\n       principal_point: [320, 240]}\n";
  };
  const RigFile rig =
      read("%YAML:1.0\ncameras:\n" + camera(kFlat, "radialtangential", "0.1, 0.2, 0.003, 0.004") +
           camera(kRight, "equidistant", "0.1, 0.2, 0.3, 0.4") +
           "camera_parameters:\n    image_delay: -0.0078\nimu_parameters:\n"
           "    sigma_g_c: 1.6e-4\n    sigma_a_c: 2.8e-3\n    sigma_gw_c: 2.2e-5\n"
           "    sigma_aw_c: 8.6e-4\n");
  expect_pair(rig);
  expect_noise(rig);
  EXPECT_EQ(rig.cameras[0].shift_ns, 7'800'000);
  EXPECT_EQ(rig.cameras[1].lens.distortion, Distortion::kEquidistant);
  // OKVIS2's names, and an IMU that is not the body: the body is 1 m along the IMU's z.
  const RigFile apart =
      read("%YAML:1.0\ncameras:\n" + camera(kFlat, "radialtangential8", "1, 2, 3, 4, 5, 6, 7, 8") +
           "camera_params:\n    image_delay: 0.002\nimu_params:\n"
           "    T_BS: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -1, 0, 0, 0, 1]\n");
  EXPECT_LT((apart.cameras.at(0).T_BC.p - Vec3(0.02, 0.05, 0.97)).norm(), 1e-12);
  EXPECT_EQ(apart.cameras[0].shift_ns, -2'000'000);
  EXPECT_EQ(apart.cameras[0].lens.d[7], 8);
  EXPECT_FALSE(apart.imu.has_value());
}

TEST_F(rig_file, asl_has_a_file_for_each_sensor) {
  disk.write("cam.yaml", "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [" +
                             std::string(kFlat) +
                             "]\nrate_hz: 20\nresolution: [752, 480]\ncamera_model: pinhole\n"
                             "intrinsics: [458.5, 457.25, 367.25, 248.5] #fu, fv, cu, cv\n"
                             "distortion_model: radial-tangential\n"
                             "distortion_coefficients: [-0.25, 0.125, 0.5, 0.0625]\n"
                             "timeshift_cam_imu: 0.0034\n");
  const RigCamera camera = read_asl_sensor(Document(disk.path("cam.yaml")));
  expect_left(camera);
  EXPECT_EQ(camera.lens.width, 752);
  EXPECT_EQ(camera.lens.fy, 457.25);
  EXPECT_EQ(camera.lens.cx, 367.25);
  EXPECT_EQ(camera.lens.d[3], 0.0625);
  EXPECT_EQ(camera.shift_ns, 3'400'000);
  disk.write("imu.yaml", imu(""));
  EXPECT_EQ(find_noise(disk.path("imu.yaml"))->noise.rate_hz, 200);
}

// Whatever part of a file is left, it is a rig or one line says why not.
TEST_F(rig_file, files_that_are_cut_off_are_told) {
  const std::string pose = "T_imu_cam: [" + std::string(kFlat) + "]";
  const std::string whole[] = {
      "cam0:\n" + kalibr_camera(pose) + "cam1:\n" + kalibr_camera(pose),
      "%YAML:1.0\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\nCamera1.fx: 400.0\n"
      "Camera1.fy: 401.0\nCamera1.cx: 320.0\nCamera1.cy: 240.0\nCamera.width: 640\n"
      "Camera.height: 480\nIMU.T_b_c1: " +
          matrix(kFlat),
      "{\"value0\":{\"T_imu_cam\":[{\"px\":0,\"py\":0,\"pz\":0,\"qx\":0,\"qy\":0,\"qz\":0,"
      "\"qw\":1}],\"intrinsics\":[{\"camera_type\":\"pinhole\",\"intrinsics\":{\"fx\":1,"
      "\"fy\":2,\"cx\":3,\"cy\":4}}],\"resolution\":[[640,480]]}}"};
  for (const std::string& text : whole) {
    EXPECT_EQ(refusal(text), "") << text;
    size_t told = 0, cuts = 0;
    for (size_t size = 0; size < text.size(); size += 11, ++cuts) {
      const std::string said = refusal(text.substr(0, size));
      EXPECT_EQ(said.find('\n'), std::string::npos) << said;
      told += !said.empty();
    }
    EXPECT_GT(told, cuts / 3);
  }
}

TEST_F(rig_file, refusals_say_what_to_do) {
  const std::string pose = "T_imu_cam: [" + std::string(kFlat) + "]";
  const std::pair<std::string, const char*> cases[] = {
      {"cam0:\n" + kalibr_camera("a: 1"), "camchain-imucam.yaml"},
      {"cam0:\n" + kalibr_camera(pose, "pinhole", "400, 401, 320, 240", "radtan", "1, 2"),
       "0, 4, 5, 8"},
      {"cam0:\n" + kalibr_camera(pose, "ocam"), "calibrate again with pinhole-equi"},
      {"cam0:\n" + kalibr_camera("T_imu_cam: [1, 2, 3]"), "4 rows of 4"},
      {"cam0:\n" + kalibr_camera("T_imu_cam: [2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]"),
       "not a rotation"},
      {"a: 1\n", "docs/formats.md"},
      {"cameras: 3\n", "needs a list"}};
  for (const auto& [text, says] : cases) {
    EXPECT_NE(refusal(text).find(says), std::string::npos) << refusal(text);
  }
}

// ---- what becomes of them ----------------------------------------------------------------------
std::string pair_of(const char* right) {
  return "cam0:\n" + kalibr_camera("T_imu_cam: [" + std::string(kFlat) + "]") + "cam1:\n" +
         kalibr_camera("T_imu_cam: [" + std::string(right) + "]") + "imu0:\n" + imu("  ");
}

TEST_F(rig_file, cameras_in_the_wrong_order_change_places) {
  disk.write("rig.yaml", "cam0:\n" + kalibr_camera("T_imu_cam: [" + std::string(kRight) + "]") +
                             "  timeshift_cam_imu: 0.25\ncam1:\n" +
                             kalibr_camera("T_imu_cam: [" + std::string(kFlat) + "]") + "imu0:\n" +
                             imu("  "));
  InputLog log;
  const Rig rig = read_rig(disk.path("rig.yaml"), {}, log);
  EXPECT_EQ(rig.camera[0], 1);
  EXPECT_EQ(rig.camera[1], 0);
  EXPECT_LT((rig.calibration.camera[0].T_BC.p - Vec3(0.02, 0.05, -0.03)).norm(), 1e-12);
  EXPECT_EQ(rig.shift_ns[1], 250'000'000);
  EXPECT_EQ(rig.calibration.camera_time_offset_ns, 0);
  InputLog quiet;
  RigOptions as_mounted;
  as_mounted.as_mounted = true;
  EXPECT_EQ(read_rig(disk.path("rig.yaml"), as_mounted, quiet).camera[0], 0);
}

// The right camera by quarter turns about its axis: a turned image shows the world upright.
TEST_F(rig_file, a_rolled_camera_gets_its_images_turned) {
  const char* const poses[] = {
      kRight,                                               // as the left one
      "0,0,1,0.02,  0,1,0,-0.05,  -1,0,0,-0.03,  0,0,0,1",  // x along its y
      "0,0,1,0.02,  1,0,0,-0.05,  0,1,0,-0.03,  0,0,0,1",   // upside down
      "0,0,1,0.02,  0,-1,0,-0.05,  1,0,0,-0.03,  0,0,0,1"};
  for (int quarters = 0; quarters < 4; ++quarters) {
    disk.write("rig.yaml", pair_of(poses[quarters]));
    InputLog log;
    const Rig rig = read_rig(disk.path("rig.yaml"), {}, log);
    EXPECT_EQ(rig.turns[1], quarters);
    EXPECT_EQ(rig.camera[0], 0);
    const Camera& left = rig.calibration.camera[0];
    const Camera& right = rig.calibration.camera[1];
    EXPECT_LT((left.T_BC.R - right.T_BC.R).norm(), 1e-12);
    // The same point of the world, on the image as it was and as it is.
    const Camera as_was = fit(read_rig_file(disk.path("rig.yaml")).cameras[1].lens).camera;
    const SE3 T_BC = read_rig_file(disk.path("rig.yaml")).cameras[1].T_BC;
    const Vec3 p_B(2, 0.3, -0.5);
    Vec2 was, is;
    ASSERT_TRUE(as_was.project(T_BC.inverse() * p_B, was));
    ASSERT_TRUE(right.project(right.T_BC.inverse() * p_B, is));
    for (int i = 0, width = 640, height = 480; i < quarters; ++i, std::swap(width, height)) {
      was = Vec2(height - 1 - was.y(), was.x());
    }
    EXPECT_LT((was - is).norm(), 1e-9) << quarters;
  }
}

TEST_F(rig_file, noise_comes_from_the_file_beside_and_is_named) {
  disk.write("rig/chain.yaml",
             "cam0:\n" + kalibr_camera("T_imu_cam: [" + std::string(kFlat) + "]"));
  InputLog none, one, asked;
  EXPECT_EQ(read_rig(disk.path("rig/chain.yaml"), {}, none).calibration.imu.gyro_noise,
            ImuNoise{}.gyro_noise);
  EXPECT_NE(none.notes.at(0).find("no IMU noise is given"), std::string::npos);
  disk.write("rig/kalibr_imu_chain.yaml", "imu0:\n" + imu("  "));
  EXPECT_EQ(read_rig(disk.path("rig/chain.yaml"), {}, one).calibration.imu.gyro_noise, 1.6e-4);
  EXPECT_NE(one.notes.at(0).find("kalibr_imu_chain.yaml, imu0: gyro 0.00016"), std::string::npos);
  disk.write("rig/imu-b.yaml", imu(""));
  EXPECT_THROW(read_rig(disk.path("rig/chain.yaml"), {}, one), InputError);
  RigOptions options;
  options.imu = disk.path("imu0/sensor.yaml");
  EXPECT_EQ(read_rig(disk.path("rig/chain.yaml"), options, asked).calibration.imu.gyro_noise,
            1.0e-4);
}

TEST_F(rig_file, noise_out_of_its_band_is_told_with_its_value) {
  Calibration calibration =
      read_asl_rig(disk.path(""), {}, *std::make_unique<InputLog>()).calibration;
  const auto says = [&](double ImuNoise::*field, double value) {
    Calibration spoiled = calibration;
    spoiled.imu.*field = value;
    try {
      check_sense(spoiled, "F");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(says(&ImuNoise::gyro_noise, 0.187).find("it is 0.187 rad/s/sqrt(Hz)"),
            std::string::npos);
  EXPECT_NE(says(&ImuNoise::gyro_noise, 2.89e-8).find("variance: give its root, 0.00017"),
            std::string::npos);
  EXPECT_EQ(says(&ImuNoise::gyro_noise, 1e-3), "");
}

}  // namespace
}  // namespace pirvs::tools
