// The clip as a log, written by programs that share no code with ours, gives the clip's trajectory.
// In      PIRVS_BUILD (default build): logs/node_modules, which make fetches. python3-rosbag.
// Out     a reason where the clip is not there.
// Cost    ~3 s a log.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "tests/logs/clip_part.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/dataset/input_error.h"

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;

struct Kind {
  const char* name;
  std::string write;  // ASL folder and duration go in front, the file behind
  bool folder = false;
};

std::string mcap(const char* compression) {
  const char* const build = std::getenv("PIRVS_BUILD");
  return "NODE_PATH=" + std::string(build != nullptr ? build : "build") +
         "/logs/node_modules node tests/logs/write_mcap.cjs CLIP " + compression;
}

const Kind kKinds[] = {
    {"bag", "/usr/bin/python3 -B tests/logs/write_bag.py CLIP none"},
    {"bag_lz4", "/usr/bin/python3 -B tests/logs/write_bag.py CLIP lz4"},
    {"bag_bz2", "/usr/bin/python3 -B tests/logs/write_bag.py CLIP bz2"},
    {"db3", "python3 -B tests/logs/write_db3.py CLIP"},
    {"mcap", mcap("none")},
    {"mcap_zstd", mcap("zstd")},
    {"rosbag2_mcap", mcap("zstd"), true},
};

std::string write(const Kind& kind, const std::string& folder, const char* more = "") {
  const std::string path = folder + "/" + kind.name;
  if (kind.folder) fs::create_directories(path);
  std::string command = kind.write;
  command.replace(command.find("CLIP"), 4, clip()->folder + " " + std::to_string(kPart_s));
  EXPECT_EQ(std::system((command + " " + path + more).c_str()), 0) << command;
  return path;
}

class logs : public testing::TestWithParam<size_t> {};

TEST_P(logs, give_the_trajectory_of_the_folder) {
  if (clip() == nullptr) GTEST_SKIP() << "no clip";
  static const std::string wanted = replay(first_part()).trajectory();
  const Kind& kind = kKinds[GetParam()];
  const std::string folder = scratch_folder(kind.name);
  const std::string path = write(kind, folder);
  tools::RecordingOptions options;
  options.calibration = calibration_file(folder);
  const tools::Recording recording = tools::open_recording(path, options);
  EXPECT_GT(recording.truth.poses.size(), 100u);
  EXPECT_TRUE(recording.rejected.empty());
  const Replay run = replay(recording);
  print(kind.name, run);
  EXPECT_EQ(run.trajectory(), wanted);
  if (kind.folder) return;
  // Cut off in the middle it is read up to there, and that is said.
  if (fs::is_regular_file(path)) {
    fs::resize_file(path, fs::file_size(path) * 2 / 3);
    const tools::Recording part = tools::open_recording(path, options);
    EXPECT_LT(part.frames.size(), recording.frames.size());
    EXPECT_GT(part.frames.size(), recording.frames.size() / 3);
    bool said = false;
    for (const std::string& note : part.notes) said |= note.find("cut off") != std::string::npos;
    EXPECT_TRUE(said);
  }
  options.calibration.clear();
  EXPECT_THROW(tools::open_recording(path, options), tools::InputError);
}

// Of a driver that publishes CameraInfo and /tf_static no calibration is needed.
TEST(log_with_rig, gives_the_error_of_the_folder) {
  if (clip() == nullptr) GTEST_SKIP() << "no clip";
  const std::string folder = scratch_folder("with_rig");
  const std::string path = write({"with_rig", mcap("none")}, folder, " rig");
  tools::RecordingOptions options;
  options.imu = clip()->folder + "/mav0/imu0/sensor.yaml";
  const tools::Recording recording = tools::open_recording(path, options);
  const Calibration& wanted = clip()->calibration;
  ASSERT_EQ(recording.calibration.cameras, 2);
  for (int c = 0; c < 2; ++c) {
    const SE3& T_BC = recording.calibration.camera[c].T_BC;
    EXPECT_LT((T_BC.R - wanted.camera[c].T_BC.R).norm(), 1e-8);
    EXPECT_LT((T_BC.p - wanted.camera[c].T_BC.p).norm(), 1e-12);
  }
  const Replay run = replay(recording);
  print("with_rig", run);
  EXPECT_NEAR(run.result.evaluation.ate_rmse_m, replay(first_part()).result.evaluation.ate_rmse_m,
              5e-5);
}

INSTANTIATE_TEST_SUITE_P(all, logs, testing::Range(size_t{0}, std::size(kKinds)),
                         [](const auto& info) { return kKinds[info.param].name; });

}  // namespace
}  // namespace pirvs::systems
