// The paper's tables (tools/paper) on stand-ins that lie as EuRoC and PennCOSYVIO do: figures are
// those of `pirvs eval`, and what is missing is named.
// In      PIRVS_BUILD (default build): host/pirvs.
// Cost    ~6 s.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/math/so3.h"
#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;

std::string output_of(const std::string& command) {
  std::string out;
  std::FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return out;
  char text[4096];
  while (const size_t got = std::fread(text, 1, sizeof text, pipe)) out.append(text, got);
  pclose(pipe);
  return out;
}

std::string text(const char* format, double value) {
  char out[40];
  std::snprintf(out, sizeof out, format, value);
  return out;
}

// As PennCOSYVIO's site gives it: from the rig's coordinates to those of the VI sensor's IMU.
SE3 rig_to_imu() {
  SE3 T;
  T.R << 0.9989551739, -0.0016800380, -0.0456698809, 0.0005817624, 0.9997105684, -0.0240508012,
      0.0456970689, 0.0239991032, 0.9986670221;
  T.R = so3_exp(so3_log(T.R));
  T.p = Vec3(-0.0310, -0.1257, -0.0171);
  return T;
}

void write_chain(const Calibration& calibration, const std::string& path) {
  std::ofstream file(path);
  for (int c = 0; c < 2; ++c) {
    const Camera& k = calibration.camera[c];
    const SE3 T_CB = k.T_BC.inverse();
    file << "cam" << c << ":\n  T_cam_imu:\n";
    for (int i = 0; i < 3; ++i) {
      file << "  - [";
      for (int j = 0; j < 3; ++j) file << text("%.17g, ", T_CB.R(i, j));
      file << text("%.17g]\n", T_CB.p[i]);
    }
    file << "  - [0, 0, 0, 1]\n  camera_model: pinhole\n  distortion_model: radtan\n"
         << "  intrinsics: [" << text("%.17g, ", k.fx) << text("%.17g, ", k.fy)
         << text("%.17g, ", k.cx) << text("%.17g]\n", k.cy) << "  distortion_coeffs: [";
    for (int i = 0; i < 4; ++i) file << text("%.17g", k.d[i]) << (i < 3 ? ", " : "]\n");
    file << "  resolution: [" << k.width << ", " << k.height << "]\n";
  }
}

// visensor/as with frames, timestamps.txt and imu.txt, the acceleration in front; the truth as
// matrices of the rig.
void write_penncosyvio(const tools::Recording& from, const std::string& root) {
  const std::string folder = root + "/visensor/as", truth = root + "/ground_truth/as";
  for (const std::string& path : {folder + "/left", folder + "/right", truth}) {
    fs::create_directories(path);
  }
  write_chain(from.calibration, root + "/visensor/camchain-imucam.yaml");
  const ImuNoise& noise = from.calibration.imu;
  std::ofstream(root + "/visensor/imu.yaml")
      << "gyroscope_noise_density: " << noise.gyro_noise
      << "\ngyroscope_random_walk: " << noise.gyro_walk
      << "\naccelerometer_noise_density: " << noise.accel_noise
      << "\naccelerometer_random_walk: " << noise.accel_walk << "\nupdate_rate: " << noise.rate_hz
      << "\n";
  std::ofstream stamps(folder + "/timestamps.txt"), imu(folder + "/imu.txt"),
      poses(truth + "/pose.txt");
  const auto put_s = [](std::ofstream& file, TimeNs t) {
    file << t / 1'000'000'000 << text("%.9f", double(t % 1'000'000'000) * 1e-9).substr(1);
  };
  for (size_t i = 0; i < from.frames.size(); ++i) {
    put_s(stamps, from.frames[i].t);
    stamps << "\n";
    for (int c = 0; c < 2; ++c) {
      char name[32];
      std::snprintf(name, sizeof name, "/frame_%04zu.png", i);
      fs::create_symlink(from.frames[i].image[c], folder + (c == 0 ? "/left" : "/right") + name);
    }
  }
  for (const ImuSample& sample : from.imu) {
    put_s(imu, sample.t);
    for (int i = 0; i < 3; ++i) imu << text(" %.17g", sample.f_B[i]);
    for (int i = 0; i < 3; ++i) imu << text(" %.17g", sample.w_B[i]);
    imu << "\n";
  }
  const SE3 T_IR = rig_to_imu();
  for (const tools::TrajectoryPose& pose : from.truth.poses) {
    const SE3 T_WI{rotation_from_quat_xyzw(pose.q_WB), pose.p_WB};
    const SE3 T_WR = T_WI * T_IR;
    put_s(poses, pose.t);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) poses << text(" %.12f", T_WR.R(i, j));
      poses << text(" %.12f", T_WR.p[i]);
    }
    poses << "\n";
  }
}

// The first number of a table's row of ours.
std::string ate_of(const std::string& table, const std::string& sequence) {
  const size_t row = table.find("\n" + sequence);
  const size_t ours = table.find("PIRVS, here", row);
  if (row == std::string::npos || ours == std::string::npos) return "";
  std::istringstream rest(table.substr(ours + 11));
  std::string out;
  rest >> out;
  return out;
}

TEST(paper, tables_of_stand_ins) {
  const tools::Recording& recording = simulated(SimulatedDevice::kEuroc);
  const std::string root = scratch_folder("paper");
  fs::create_directories(root + "/euroc/machine_hall");
  fs::create_directory_symlink(fs::absolute(recording.folder),
                               root + "/euroc/machine_hall/MH_04_difficult");
  write_penncosyvio(recording, root + "/penncosyvio");
  const char* const build = std::getenv("PIRVS_BUILD");
  const std::string pirvs = std::string(build != nullptr ? build : "build") + "/host/pirvs";
  const std::string table =
      output_of("tools/paper/paper --starts 1 --pirvs " + pirvs + " --out " + root +
                "/out --euroc " + root + "/euroc --penncosyvio " + root + "/penncosyvio");
  // Beside the paper's own, and OKVIS's.
  EXPECT_NE(table.find("0.1227"), std::string::npos) << table;
  EXPECT_NE(table.find("0.6293"), std::string::npos);
  EXPECT_NE(table.find("PIRVS, here (PennCOSYVIO AS)"), std::string::npos);
  for (const char* name : {"MH_01_easy", "V2_03_difficult", "bf"}) {
    EXPECT_NE(table.find(std::string("missing: ") + name + ": not at "), std::string::npos) << name;
  }
  const std::string euroc = ate_of(table, "MH_04_difficult");
  const std::string eval =
      output_of(pirvs + " eval " + root + "/out/runs/MH_04_difficult/0/trajectory.tum " +
                recording.folder + "/mav0/state_groundtruth_estimate0/data.csv");
  EXPECT_FALSE(euroc.empty());
  EXPECT_NE(eval.find("ATE rmse " + euroc + " m"), std::string::npos) << eval << table;
  // The same recording by its other layout, and its truth by way of the rig.
  EXPECT_NEAR(std::atof(ate_of(table, "PennCOSYVIO AS").c_str()), std::atof(euroc.c_str()), 0.002);
  EXPECT_NE(output_of("tools/paper/paper").find("give --euroc"), std::string::npos);
}

}  // namespace
}  // namespace pirvs::systems
