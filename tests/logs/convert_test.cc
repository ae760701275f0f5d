// A recording written in other forms is the same recording, and what a run writes as MCAP is what
// its other files say, as Foxglove's own readers see it.
// In      PIRVS_BUILD (default build): host/pirvs, and logs/node_modules, which make fetches.
// Out     a reason where the clip is not there.
// Cost    ~10 s in all.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/logs/clip_part.h"
#include "tests/programs.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/convert/writers.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/player.h"

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;

// What an independent reader prints; empty: it failed.
std::string read_by_npm(const std::string& mcap) {
  return said_by("NODE_PATH=" + build_folder() +
                 "/logs/node_modules node tests/logs/read_mcap.cjs " + mcap);
}

bool has_line(const std::string& text, const std::string& line) {
  return ("\n" + text).find("\n" + line + "\n") != std::string::npos;
}

std::string content(const std::string& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

void nothing(size_t) {}

TEST(convert, to_mcap_and_back_is_the_same_recording) {
  if (clip() == nullptr) GTEST_SKIP() << "no clip";
  const tools::Recording part = first_part();
  const std::string folder = scratch_folder("convert");
  tools::InputLog log;
  tools::write_mcap(part, folder + "/clip.mcap", nothing, log);
  const tools::Recording mcap = tools::open_recording(folder + "/clip.mcap", {});
  tools::write_asl(mcap, folder + "/asl", nothing, log);
  const tools::Recording asl = tools::open_recording(folder + "/asl", {});
  EXPECT_TRUE(log.rejected.empty());
  // The very images, and the very numbers.
  const std::string first = part.frames.front().image[1];
  EXPECT_EQ(content(asl.frames.front().image[1]), content(first));
  ASSERT_EQ(asl.imu.size(), part.imu.size());
  for (size_t i = 0; i < part.imu.size(); ++i) {
    ASSERT_EQ(asl.imu[i].t, part.imu[i].t);
    ASSERT_EQ(asl.imu[i].w_B, part.imu[i].w_B);
    ASSERT_EQ(asl.imu[i].f_B, part.imu[i].f_B);
  }
  ASSERT_EQ(asl.truth.poses.size(), part.truth.poses.size());
  const std::string wanted = tools::to_line(replay(part).result.evaluation);
  EXPECT_EQ(tools::to_line(replay(mcap).result.evaluation), wanted);
  EXPECT_EQ(tools::to_line(replay(asl).result.evaluation), wanted);
  const std::string seen = read_by_npm(folder + "/clip.mcap");
  const std::string frames = std::to_string(part.frames.size());
  EXPECT_TRUE(has_line(seen, "topic /imu0 sensor_msgs/msg/Imu " + std::to_string(part.imu.size())));
  for (const char* camera : {"/cam0", "/cam1"}) {
    EXPECT_TRUE(has_line(seen, std::string("topic ") + camera +
                                   "/image_raw/compressed sensor_msgs/msg/CompressedImage " +
                                   frames));
  }
  EXPECT_THROW(tools::write_asl(part, folder + "/asl", nothing, log), tools::InputError);
  EXPECT_THROW(tools::write_mcap(part, folder + "/clip.mcap", nothing, log), tools::InputError);
}

// Images that lie in no file: turned ones are written as they are played.
TEST(convert, writes_what_is_played_of_turned_images) {
  tools::Recording turned = simulated(SimulatedDevice::kEuroc);
  turned.frames.resize(3);
  turned.turns[1] = 2;
  const std::string folder = scratch_folder("convert_turned");
  tools::InputLog log;
  tools::write_asl(turned, folder + "/asl", nothing, log);
  const tools::Recording read = tools::open_recording(folder + "/asl", {});
  ASSERT_EQ(read.frames.size(), 3u);
  EXPECT_EQ(fs::path(read.frames[0].image[1]).extension(), ".png");
  tools::Player wanted(turned), got(read);
  const StereoFrame *a = wanted.next(), *b = got.next();
  for (int y = 0; y < a->image[1].height; ++y) {
    ASSERT_EQ(std::memcmp(a->image[1].row(y), b->image[1].row(y), size_t(a->image[1].width)), 0);
  }
}

TEST(run_mcap, holds_what_the_other_files_say) {
  if (clip() == nullptr) GTEST_SKIP() << "no clip";
  const std::string out = scratch_folder("run_mcap");
  const std::string command = build_folder() + "/host/pirvs run " + clip()->folder +
                              " --duration 4 --mcap --record " + out + "/input.mcap --out " + out +
                              " > " + out + ".txt 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << content(out + ".txt");
  const std::string seen = read_by_npm(out + "/run.mcap");
  std::istringstream poses(content(out + "/trajectory.tum"));
  size_t count = 0;
  for (std::string line; std::getline(poses, line); ++count) {
    EXPECT_TRUE(has_line(seen, line)) << line;
  }
  EXPECT_GT(count, 40u);
  EXPECT_TRUE(has_line(seen, "topic /odom nav_msgs/msg/Odometry " + std::to_string(count)));
  EXPECT_TRUE(has_line(seen, "topic /tf tf2_msgs/msg/TFMessage " + std::to_string(count)));
  EXPECT_TRUE(has_line(seen, "topic /truth nav_msgs/msg/Path 1"));
  EXPECT_TRUE(has_line(seen, "topic /cam0/image_raw/compressed sensor_msgs/msg/CompressedImage 9"));
  const std::string ply = content(out + "/map.ply");
  const std::string points = ply.substr(ply.find("vertex ") + 7);
  EXPECT_TRUE(has_line(seen, "points " + points.substr(0, points.find('\n'))));
  const std::string input = read_by_npm(out + "/input.mcap");
  EXPECT_TRUE(
      has_line(input, "topic /cam1/image_raw/compressed sensor_msgs/msg/CompressedImage 81"));
  EXPECT_FALSE(fs::exists(out + "/input.mcap.folder"));
  EXPECT_NE(seen.find("topic /health diagnostic_msgs/msg/DiagnosticArray "), std::string::npos);
}

}  // namespace
}  // namespace pirvs::systems
