// What the world does to sensors and disks: the stack goes on, counts it by name, and ends sanely.
// Each fault is put into the simulated EuRoC recording in memory (118 frames, first pose ~0.8 s).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/cli/command.h"
#include "tools/dataset/input_error.h"

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;
using tools::FrameFiles;
using tools::Recording;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kAteOfPath_max = 0.01;  // after a fault that the stack bridges

Recording recording() { return simulated(SimulatedDevice::kEuroc); }

size_t imu_index(const Recording& recording, double t_s) {
  const TimeNs t = recording.frames.front().t + from_seconds(t_s);
  size_t i = 0;
  while (recording.imu[i].t < t) ++i;
  return i;
}

std::string image_of(uint8_t grey) {
  static const std::string folder = scratch_folder("flat");
  const std::string path = folder + "/" + std::to_string(grey) + ".png";
  cv::imwrite(path, cv::Mat(480, 752, CV_8U, cv::Scalar(grey)));
  return path;
}

void expect_bridged(const Replay& run) {
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_LE(run.ate_of_path(), kAteOfPath_max);
}

TEST(fault, truncated_and_undecodable_images) {
  const std::string folder = scratch_folder("broken");
  Recording broken = recording();
  std::string bytes(fs::file_size(broken.frames[40].image[0]), '\0');
  std::ifstream(broken.frames[40].image[0], std::ios::binary).read(&bytes[0], bytes.size());
  std::ofstream(folder + "/half.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  std::ofstream(folder + "/text.png", std::ios::binary) << "this is not an image";
  std::ofstream(folder + "/empty.png", std::ios::binary);
  cv::imwrite(folder + "/small.png", cv::Mat(48, 64, CV_8U, cv::Scalar(0)));
  broken.frames[40].image[0] = folder + "/half.png";
  broken.frames[45].image[1] = folder + "/text.png";
  broken.frames[50].image[0] = folder + "/empty.png";
  broken.frames[55].image[1] = folder + "/small.png";
  broken.frames[60].image[0] = broken.frames[60].image[1] = folder + "/nothing.png";
  const Replay run = replay(broken);
  print("broken images", run);
  expect_bridged(run);
  EXPECT_EQ(run.counter("images_cut_off"), 2u);
  EXPECT_EQ(run.counter("images_undecodable"), 1u);
  EXPECT_EQ(run.counter("images_of_wrong_size"), 1u);
  EXPECT_EQ(run.counter("images_missing"), 2u);
  EXPECT_EQ(run.counter("camera_missing"), 5u);
  EXPECT_EQ(run.result.frames_dropped, 1u);  // the one with neither
}

TEST(fault, a_camera_is_missing_for_some_frames) {
  Recording lame = recording();
  for (size_t i = 30; i < 45; ++i) lame.frames[i].image[1].clear();
  for (size_t i = 70; i < 80; ++i) lame.frames[i].image[0].clear();
  const Replay run = replay(lame);
  print("one camera missing", run);
  expect_bridged(run);
  EXPECT_EQ(run.counter("camera_missing"), 25u);
}

TEST(fault, imu_gap_of_0_3_s) {
  Recording gap = recording();
  const auto begin = gap.imu.begin();
  gap.imu.erase(begin + imu_index(gap, 3.0), begin + imu_index(gap, 3.3));
  const Replay run = replay(gap);
  print("IMU gap", run);
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_gap"), 1u);
}

TEST(fault, imu_samples_that_are_no_numbers) {
  Recording noise = recording();
  const size_t at = imu_index(noise, 2.5);
  noise.imu[at].w_B.x() = kNaN;
  noise.imu[at + 1].f_B.z() = kNaN;
  noise.imu[at + 2].w_B.y() = std::numeric_limits<double>::infinity();
  const Replay run = replay(noise);
  print("IMU not finite", run);
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_not_finite"), 3u);
}

TEST(fault, imu_samples_beyond_any_range) {
  for (const double value : {1e3, 1e30, 1e300}) {
    Recording spike = recording();
    const size_t at = imu_index(spike, 2.5);
    spike.imu[at].w_B.x() = value;
    spike.imu[at + 1].f_B.z() = -value;
    const Replay run = replay(spike);
    print("IMU spike", run);
    expect_bridged(run);
    EXPECT_EQ(run.counter("imu_out_of_range"), 2u);
  }
}

// Within the sensor's range, but nothing that the body did: the pose may suffer, not the process.
TEST(fault, imu_spikes_within_range) {
  Recording spike = recording();
  const size_t at = imu_index(spike, 2.5);
  spike.imu[at].w_B.x() = 34.9;
  spike.imu[at + 1].f_B.z() = -156;
  const Replay run = replay(spike);
  print("IMU spike within range", run);
  for (const tools::TrajectoryPose& pose : run.result.trajectory.poses) {
    ASSERT_TRUE(pose.p_WB.allFinite() && pose.q_WB.allFinite());
  }
  EXPECT_EQ(run.result.exit_status(), 0);
}

TEST(fault, images_that_stand_still_for_a_second) {
  Recording frozen = recording();
  for (size_t i = 60; i < 80; ++i) {
    for (int c = 0; c < 2; ++c) frozen.frames[i].image[c] = frozen.frames[59].image[c];
  }
  const Replay run = replay(frozen);
  print("frozen for 1 s", run);
  for (const tools::TrajectoryPose& pose : run.result.trajectory.poses) {
    ASSERT_TRUE(pose.p_WB.allFinite());
  }
  EXPECT_GE(run.result.frames_tracked, 90u);
}

TEST(fault, stamps_that_repeat_or_go_back) {
  Recording again = recording();
  const size_t at = imu_index(again, 2.5);
  again.imu.insert(again.imu.begin() + at, again.imu[at]);            // twice
  again.imu.insert(again.imu.begin() + at + 50, again.imu[at + 20]);  // an old one
  again.frames.insert(again.frames.begin() + 60, again.frames[60]);
  again.frames.insert(again.frames.begin() + 80, again.frames[70]);
  const Replay run = replay(again);
  print("stamps not rising", run);
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_backwards"), 2u);
  EXPECT_EQ(run.counter("frame_backwards"), 2u);
  EXPECT_EQ(run.result.frames_dropped, 2u);
}

TEST(fault, black_images_for_a_second) {
  Recording dark = recording();
  for (size_t i = 60; i < 80; ++i) dark.frames[i].image[0] = dark.frames[i].image[1] = image_of(0);
  const Replay run = replay(dark);
  print("black for 1 s", run);
  EXPECT_EQ(run.result.exit_status(), 0);
  bool degraded = false;
  for (const tools::HealthEvent& event : run.log.health) {
    degraded =
        degraded || event.state == HealthState::kDegraded || event.state == HealthState::kLost;
  }
  EXPECT_TRUE(degraded) << "health must say that it is blind";
  for (const FrameReport& frame : run.log.frames) {
    ASSERT_TRUE(frame.pose.state.T_WB.p.allFinite());
  }
  EXPECT_LE(run.ate_of_path(), 5 * kAteOfPath_max);
}

TEST(fault, flat_images_from_the_start_give_no_pose) {
  for (const uint8_t grey : {0, 255}) {
    Recording blind = recording();
    for (FrameFiles& frame : blind.frames) frame.image[0] = frame.image[1] = image_of(grey);
    const Replay run = replay(blind, grey == 0 ? 1 : 2);
    EXPECT_EQ(run.status, Status::kBadData);
    EXPECT_EQ(run.result.exit_status(), 1);
    EXPECT_EQ(run.result.frames_before_start, run.result.frames_in);
  }
}

TEST(fault, one_camera_alone_never_starts_and_ends) {
  Recording mono = recording();
  mono.calibration.cameras = 1;
  for (FrameFiles& frame : mono.frames) frame.image[1].clear();
  const Replay run = replay(mono);
  EXPECT_EQ(run.result.exit_status(), run.result.trajectory.poses.empty() ? 1 : 0);
  EXPECT_EQ(run.counter("camera_missing"), mono.frames.size());
}

TEST(fault, sensors_that_end_early) {
  Recording deaf = recording();  // IMU ends in the middle
  deaf.imu.resize(imu_index(deaf, 3.0));
  const Replay deaf_run = replay(deaf);
  EXPECT_GT(deaf_run.counter("frame_without_imu"), 50u);
  Recording blind = recording();  // the cameras do
  blind.frames.resize(60);
  EXPECT_EQ(replay(blind).result.exit_status(), 0);
  Recording instant = recording();
  instant.frames.resize(1);
  EXPECT_EQ(replay(instant).result.exit_status(), 1);
  Recording late = recording();  // the IMU starts after some frames
  late.imu.erase(late.imu.begin(), late.imu.begin() + imu_index(late, 0.5));
  const Replay late_run = replay(late);
  EXPECT_EQ(late_run.result.exit_status(), 0);
  EXPECT_GE(late_run.counter("frame_before_imu"), 9u);
}

// `pirvs run` as the command line calls it; an InputError is its exit status 2.
int run_command(const std::string& sequence, const std::string& out) {
  CLI::App options;
  const std::function<int()> run = tools::kRunCommand.declare(options);
  std::vector<std::string> arguments = {"--out", out, "--duration", "1.5", sequence};
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  options.parse(arguments);
  return run();
}

std::string error_of(const std::string& sequence, const std::string& out) {
  try {
    return "exit status " + std::to_string(run_command(sequence, out));
  } catch (const tools::InputError& error) {
    return error.what();
  }
}

TEST(fault, full_disk_is_said_in_one_line) {
  for (const char* file : {"trajectory.tum", "timing.csv", "summary.json", "report.html"}) {
    const std::string out = scratch_folder("full");
    fs::create_symlink("/dev/full", out + "/" + file);
    const std::string error = error_of(recording().folder, out);
    EXPECT_NE(error.find(file), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  }
}

TEST(fault, empty_recordings_are_refused) {
  const std::string out = scratch_folder("out");
  for (const char* emptied : {"cam0/data.csv", "cam1/data.csv", "imu0/data.csv"}) {
    const std::string folder = scratch_folder("empty");
    fs::copy(recording().folder, folder,
             fs::copy_options::recursive | fs::copy_options::create_hard_links |
                 fs::copy_options::overwrite_existing);
    fs::remove(folder + "/mav0/" + emptied);  // or the original would be emptied with it
    std::ofstream(folder + "/mav0/" + emptied) << "#timestamp [ns]\n";
    EXPECT_NE(error_of(folder, out).find(emptied), std::string::npos);
  }
  EXPECT_NE(error_of(scratch_folder("empty"), out).find("cam0"), std::string::npos);
}

}  // namespace
}  // namespace pirvs::systems
