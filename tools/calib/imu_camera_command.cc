// `pirvs calib imu-camera`: cameras against the IMU, and the IMU itself.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/math/so3.h"
#include "tools/calib/board_images.h"
#include "tools/calib/calib_command.h"
#include "tools/calib/corner_input.h"
#include "tools/calib/imu_camera.h"
#include "tools/calib/result_files.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/sensor_tables.h"

namespace pirvs::tools {
namespace {

constexpr double kDegrees = 180 / M_PI;

struct Options {
  CornerOptions corners;
  ImuCameraOptions how;
  std::string imu, noise, out;
  bool plain_imu = false;
};

void print_triple(const char* name, const Vec3& value, const Vec3& sigma, const char* unit) {
  std::printf("%s  %10.5f %10.5f %10.5f  +- %.5f %.5f %.5f %s\n", name, value.x(), value.y(),
              value.z(), sigma.x(), sigma.y(), sigma.z(), unit);
}

void print(const ImuCameraResult& r) {
  std::printf("%zu shots, %zu samples, a knot every %g ms\n", r.frames, r.samples, 1e3 * r.knot_s);
  for (int c = 0; c < r.rig.cameras; ++c) {
    const CameraToImu& camera = r.camera[c];
    const std::string name = "cam" + std::to_string(c);
    print_triple((name + " log R_BC").c_str(), kDegrees * so3_log(camera.T_BC.R),
                 kDegrees * camera.sigma.head<3>(), "deg");
    print_triple((name + " p_BC    ").c_str(), 1e3 * camera.T_BC.p,
                 1e3 * camera.sigma.segment<3>(3), "mm");
    std::printf("%s time offset %.4f ms +- %.4f, drift %.2g +- %.2g\n", name.c_str(),
                1e3 * camera.offset_s, 1e3 * camera.sigma[6], camera.drift, camera.sigma[7]);
    std::printf("%s reprojection %.3f px\n", name.c_str(), camera.rms_px);
  }
  for (int i = 0; i < 3; ++i) {
    print_triple("gyro matrix  ", r.gyro.row(i), r.gyro_sigma.row(i), "");
  }
  for (int i = 0; i < 3; ++i) {
    print_triple("accel matrix ", r.accel.row(i), r.accel_sigma.row(i), "");
  }
  print_triple("gyro bias    ", r.b_g, r.b_g_sigma, "rad/s");
  print_triple("accel bias   ", r.b_a, r.b_a_sigma, "m/s^2");
  std::printf("gyro residual %.5f rad/s, %.2f of its density; accelerometer %.5f m/s^2, %.2f\n",
              r.gyro_rms, r.gyro_excess, r.accel_rms, r.accel_excess);
  if (r.rig.cameras == 2) {
    std::printf("baseline %.3f mm +- %.3f\n", 1e3 * r.baseline_m, 1e3 * r.baseline_sigma_m);
  }
  for (const std::string& what : r.unexcited) {
    std::printf("not excited by the motion, keeps its prior: %s\n", what.c_str());
  }
}

int run(const Options& o) {
  const CornerInput input = read_corner_input(o.corners);
  const std::string own = o.corners.sequence.empty() ? "" : mav0_of(o.corners.sequence) + "/imu0";
  if (o.imu.empty() && own.empty()) {
    throw InputError("no IMU samples", "--imu", "give them, or a recording that has them");
  }
  const std::string path = o.imu.empty() ? own + "/data.csv" : o.imu;
  InputLog log;
  const std::vector<ImuSample> imu = read_imu_samples(path, log);
  print_log(path, log);
  ImuCameraOptions how = o.how;
  how.imu_intrinsics = !o.plain_imu;
  const bool has_own = !own.empty() && std::filesystem::exists(own + "/sensor.yaml");
  if (!o.noise.empty() || has_own) {
    how.noise = read_noise(o.noise.empty() ? own + "/sensor.yaml" : o.noise);
  }
  const CameraResult cameras =
      calibrate_cameras(input.target, input.shots, input.cameras, input.how);
  print_cameras(cameras);
  const ImuCameraResult result = calibrate_imu_camera(cameras, imu, how);
  print(result);
  if (o.out.empty()) return kExitDone;
  const double offset_s[2] = {result.camera[0].offset_s, result.camera[1].offset_s};
  const FoundImu found{how.noise, intrinsics_of(result)};
  write_sensor_files(o.out, result.rig, offset_s, &found);
  write_camchain(o.out, result.rig, offset_s, &found);
  write_json(o.out + "/calibration.json",
             {{"cameras", camera_json(cameras)}, {"imu_camera", imu_json(result)}});
  std::printf("written: %s\n", o.out.c_str());
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  declare_corners(app, o->corners);
  app.add_option("--imu", o->imu,
                 "samples: stamp, gyro rad/s, accelerometer m/s^2; else the recording's");
  app.add_option("--noise", o->noise, "densities, Kalibr's imu.yaml or an ASL sensor.yaml");
  app.add_option("--knot", o->how.knot_s, "distance of the spline's knots, s; else by the motion")
      ->check(CLI::Range(0.002, 0.2));
  app.add_flag("--plain-imu", o->plain_imu, "take scale and axes of the IMU as they are");
  app.add_option("--out", o->out,
                 "folder for sensor.yaml files, Kalibr's yaml and calibration.json");
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibImuCameraCommand = {
    "imu-camera", "Cameras against the IMU: place, rotation, time; the IMU's scale and axes",
    declare};

}  // namespace pirvs::tools
