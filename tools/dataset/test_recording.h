// What    A tiny recording on disk for tests: 12 stereo frames of 64 x 48, 5 ms IMU, ground truth.
// In      nothing; the folder is below the system's temporary folder.
// Out     folder(): an ASL recording to break in one way or another; removed at the end.
// Errors  an assert of the test if the disk refuses.
// Cost    ~5 ms.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>

namespace pirvs::tools {

class TestRecording {
 public:
  static constexpr int kFrames = 12;
  static constexpr int kImuSamples = 121;
  static constexpr long long kBegin_ns = 1'500'000'000'000'000'000;

  TestRecording() {
    static int made = 0;
    const auto name = "pirvs_test_" + std::to_string(getpid()) + "_" + std::to_string(made++);
    folder_ = (std::filesystem::temp_directory_path() / name).string();
    write_cameras();
    write("imu0/sensor.yaml",
          "rate_hz: 200\ngyroscope_noise_density: 1.0e-4\ngyroscope_random_walk: 2.0e-5\n"
          "accelerometer_noise_density: 3.0e-3\naccelerometer_random_walk: 4.0e-3\n");
    std::string imu = "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n";
    std::string truth = "#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z\n";
    for (int i = 0; i < kImuSamples; ++i) {
      const std::string t = std::to_string(kBegin_ns - 20'000'000 + i * 5'000'000ll);
      imu += t + ",0.01,0.02,0.03,0.1,0.2,9.81\n";
      truth += t + "," + std::to_string(0.001 * i) + ",0,0,1,0,0,0\n";
    }
    write("imu0/data.csv", imu);
    write("state_groundtruth_estimate0/data.csv", truth);
  }
  ~TestRecording() { std::filesystem::remove_all(folder_); }
  TestRecording(const TestRecording&) = delete;
  TestRecording& operator=(const TestRecording&) = delete;

  const std::string& folder() const { return folder_; }
  std::string path(const std::string& file) const { return folder_ + "/mav0/" + file; }
  std::string image(int camera, int frame) const {
    const std::string stamp = std::to_string(kBegin_ns + frame * 50'000'000ll);
    return path("cam" + std::to_string(camera) + "/data/" + stamp + ".png");
  }

  void write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(path(file)).parent_path());
    std::ofstream(path(file), std::ios::binary) << text;
  }
  std::string read(const std::string& file) const {
    std::ostringstream text;
    text << std::ifstream(path(file), std::ios::binary).rdbuf();
    return text.str();
  }
  // Replaces the first occurrence; the test fails if there is none.
  void replace(const std::string& file, const std::string& from, const std::string& to) const {
    std::string text = read(file);
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write(file, text.replace(at, from.size(), to));
  }
  // Keeps the first part of the file, as a full disk or a lost battery does.
  void truncate(const std::string& full_path, double part) const {
    const auto size = double(std::filesystem::file_size(full_path));
    std::filesystem::resize_file(full_path, uintmax_t(size * part));
  }

 private:
  std::string folder_;

  void write_cameras() const {
    for (int c = 0; c < 2; ++c) {
      const std::string camera = "cam" + std::to_string(c);
      write(camera + "/sensor.yaml",
            "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, " + std::to_string(0.1 * c) +
                ", 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nrate_hz: 20\nresolution: [64, 48]\n"
                "camera_model: pinhole\nintrinsics: [50.0, 51.0, 31.5, 23.5]\n"
                "distortion_model: radial-tangential\n"
                "distortion_coefficients: [-0.1, 0.01, 0.001, 0.002]\n");
      std::filesystem::create_directories(path(camera + "/data"));
      std::string list = "#timestamp [ns],filename\n";
      for (int i = 0; i < kFrames; ++i) {
        const std::string stamp = std::to_string(kBegin_ns + i * 50'000'000ll);
        list += stamp + "," + stamp + ".png\n";
        cv::Mat picture(48, 64, CV_8UC1);
        for (int k = 0; k < 48 * 64; ++k) picture.data[k] = uint8_t((k * 7 + i * 31 + c * 5) % 251);
        cv::imwrite(image(c, i), picture);
      }
      write(camera + "/data.csv", list);
    }
  }
};

}  // namespace pirvs::tools
