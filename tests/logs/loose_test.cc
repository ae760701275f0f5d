// The clip as loose files, a lossless video or images with tables beside them, gives the clip's
// trajectory.
// In      the clip; without it, a simulated recording.
// Out     a reason where the clip is not there.
// Cost    ~4 s a kind.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/logs/clip_part.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/dataset/input_error.h"

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;

using LongLong = long long;

// Seconds since the device was started, with a counter in front, as phones write them.
constexpr TimeNs kStart = 1'403'636'000'000'000'000;

std::string seconds(TimeNs t) {
  char text[32];
  const TimeNs since = t - kStart;
  std::snprintf(text, sizeof text, "%lld.%09lld", LongLong(since / 1'000'000'000),
                LongLong(since % 1'000'000'000));
  return text;
}

void write_imu(const tools::Recording& part, const std::string& folder) {
  std::ofstream gyro(folder + "/Gyroscope.csv"), accel(folder + "/Accelerometer.csv");
  gyro << "time,x,y,z\n";
  accel << "time,x,y,z\n";
  const auto row = [](TimeNs t, const Vec3& v) {
    char text[128];
    std::snprintf(text, sizeof text, "%s,%.17g,%.17g,%.17g\n", seconds(t).c_str(), v.x(), v.y(),
                  v.z());
    return std::string(text);
  };
  for (const ImuSample& sample : part.imu) {
    gyro << row(sample.t, sample.w_B);
    accel << row(sample.t, sample.f_B);
  }
}

void write_video(const tools::Recording& part, int c, const std::string& path) {
  const Camera& camera = part.calibration.camera[c];
  cv::VideoWriter video(path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 20,
                        cv::Size(camera.width, camera.height), false);
  ASSERT_TRUE(video.isOpened());
  for (const tools::FrameFiles& frame : part.frames) {
    video.write(cv::imread(frame.image[c], cv::IMREAD_GRAYSCALE));
  }
}

// The trajectory with its stamps since 1970.
std::string trajectory_of(tools::Recording recording) {
  for (tools::FrameFiles& frame : recording.frames) frame.t += kStart;
  for (ImuSample& sample : recording.imu) sample.t += kStart;
  return replay(recording).trajectory();
}

TEST(loose, videos_give_the_trajectory_of_the_folder) {
  if (clip() == nullptr) GTEST_SKIP() << "no clip";
  const tools::Recording part = first_part();
  const std::string wanted = replay(part).trajectory();
  const std::string folder = scratch_folder("videos");
  tools::RecordingOptions options;
  options.calibration = calibration_file(scratch_folder("videos_calibration"));
  for (int c = 0; c < 2; ++c) write_video(part, c, folder + (c == 0 ? "/left" : "/right") + ".mkv");
  EXPECT_THROW(tools::open_recording(folder, options), tools::InputError) << "no IMU";
  write_imu(part, folder);
  EXPECT_THROW(tools::open_recording(folder, options), tools::InputError) << "no stamps";
  std::ofstream stamps(folder + "/frames.csv");
  for (size_t i = 0; i < part.frames.size(); ++i) {
    stamps << i << "," << seconds(part.frames[i].t) << "\n";
  }
  stamps.close();
  const tools::Recording recording = tools::open_recording(folder, options);
  EXPECT_EQ(recording.kind, "video and tables");
  EXPECT_EQ(trajectory_of(recording), wanted);
  // One of them alone, by its own name.
  const tools::Recording mono = tools::open_recording(folder + "/left.mkv", options);
  EXPECT_EQ(mono.calibration.cameras, 1);
  EXPECT_EQ(mono.frames.size(), part.frames.size());
}

TEST(loose, images_give_the_trajectory_of_the_folder) {
  if (clip() == nullptr) GTEST_SKIP() << "no clip";
  const tools::Recording part = first_part();
  const std::string wanted = replay(part).trajectory();
  const std::string folder = scratch_folder("images");
  fs::copy_file(calibration_file(scratch_folder("images_calibration")),
                folder + "/calibration.cfg");
  std::ofstream stamps(folder + "/timestamps.txt"), imu(folder + "/imu.txt");
  for (const char* camera : {"cam0", "cam1"}) {
    fs::create_directories(folder + "/" + camera);
  }
  for (size_t i = 0; i < part.frames.size(); ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "%05zu.jpg", i);
    for (int c = 0; c < 2; ++c) {
      fs::copy_file(part.frames[i].image[c], folder + "/cam" + std::to_string(c) + "/" + name);
    }
    stamps << part.frames[i].t << "\n";
  }
  for (const ImuSample& sample : part.imu) {
    char text[256];
    std::snprintf(text, sizeof text, "%lld %.17g %.17g %.17g %.17g %.17g %.17g\n",
                  LongLong(sample.t), sample.w_B.x(), sample.w_B.y(), sample.w_B.z(),
                  sample.f_B.x(), sample.f_B.y(), sample.f_B.z());
    imu << text;
  }
  stamps.close();
  imu.close();
  const tools::Recording recording = tools::open_recording(folder, {});
  EXPECT_EQ(recording.kind, "images and tables");
  EXPECT_EQ(replay(recording).trajectory(), wanted);
}

}  // namespace
}  // namespace pirvs::systems
