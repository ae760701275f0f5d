#include "tools/calib/board_recording.h"

#include <cstdio>
#include <filesystem>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/calib/result_files.h"
#include "tools/dataset/input_error.h"
#include "tools/sim/sensor_folder.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

std::string row(const char* format, TimeNs t, const Vec3& w_B, const Vec3& f_B) {
  char out[256];
  std::snprintf(out, sizeof out, format, static_cast<long long>(t), w_B.x(), w_B.y(), w_B.z(),
                f_B.x(), f_B.y(), f_B.z());
  return out;
}

void draw_camera(const SimulatedDevice& device, const DrawnRecording& how,
                 const std::string& folder, int c) {
  constexpr int kPoses = 9;
  const std::string data = folder + "/data";
  std::error_code error;
  fs::create_directories(data, error);
  const BoardCamera camera(device.target, device.rig.camera[c]);
  const Target& target = device.target;
  SE3 T_TO;
  T_TO.p.x() = (1 + how.second_board) * target.columns * target.pitch_m();
  std::string rows = "#timestamp [ns],filename\n";
  uint64_t seed = 2 * uint64_t(c);
  for (const TimeNs t : device.stamps(how.motion)) {
    std::vector<SE3> T_CT, T_CO;
    for (int k = 0; k < kPoses; ++k) {
      const double late_s = how.exposure_s * ((k + 0.5) / kPoses - 0.5);
      const SE3 T_C0T = device.pose(how.motion, t + from_seconds(late_s));
      T_CT.push_back(c == 0 ? T_C0T : device.rig.T_C1C0 * T_C0T);
      T_CO.push_back(T_CT.back() * T_TO);
    }
    seed += 4;
    cv::Mat image = camera.draw(T_CT, how.light, seed);
    if (how.second_board > 0) {
      // Beside the boards both are of the wall's grey, and their faces do not overlap.
      const cv::Mat other = camera.draw(T_CO, how.light, seed + 1);
      const double wall = (how.light.white + how.light.black) / 2;
      cv::Mat far_from_wall, far_other, take;
      cv::absdiff(image, cv::Scalar(wall), far_from_wall);
      cv::absdiff(other, cv::Scalar(wall), far_other);
      cv::compare(far_other, far_from_wall, take, cv::CMP_GT);
      other.copyTo(image, take);
    }
    const std::string name = std::to_string(t) + ".pgm";
    if (!cv::imwrite(data + "/" + name, image)) {
      throw InputError("cannot write", data + "/" + name, "check space and permissions");
    }
    rows += std::to_string(t) + "," + name + "\n";
  }
  std::FILE* const table = std::fopen((folder + "/data.csv").c_str(), "w");
  const bool good = table != nullptr && std::fputs(rows.c_str(), table) >= 0;
  if (table == nullptr || std::fclose(table) != 0 || !good) {
    throw InputError("cannot write", folder, "check space and permissions");
  }
}

void write_samples(SimulatedDevice& device, const DrawnRecording& how, const std::string& folder) {
  std::string rows = "#timestamp [ns],w_x [rad s^-1],w_y,w_z,a_x [m s^-2],a_y,a_z\n";
  for (const ImuSample& s : device.samples(how.motion)) {
    rows += row("%lld,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", s.t, s.w_B, s.f_B);
  }
  write_sensor_folder(folder, rows, "");
  write_imu_yaml(folder + "/sensor.yaml", {device.noise, {}});
}

}  // namespace

void write_board_recording(SimulatedDevice& device, const DrawnRecording& how,
                           const std::string& folder) {
  const std::string mav0 = folder + "/mav0";
  std::future<void> cameras[2];
  for (int c = 0; c < 2; ++c) {
    cameras[c] = std::async(std::launch::async, [&, c] {
      draw_camera(device, how, mav0 + "/cam" + std::to_string(c), c);
    });
  }
  for (auto& camera : cameras) camera.wait();
  for (auto& camera : cameras) camera.get();
  write_samples(device, how, mav0 + "/imu0");
  write_target(device.target, folder + "/target.yaml");
  const double offset_s[2] = {device.offset_s, device.offset_s};
  const FoundImu truth{device.noise, device.imu};
  write_sensor_files(folder + "/truth", device.rig, offset_s, &truth);
  write_device_file(folder + "/truth/calibration.cfg", device.rig, offset_s, truth);
}

}  // namespace pirvs::tools
