// Recordings played as live sensors would: latency of poses, commands while it runs, and what was
// recorded of it replayed to the same bytes.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;
using tools::Playback;

class Folder {
 public:
  explicit Folder(const char* name)
      : path_(fs::temp_directory_path() / (name + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  std::string path() const { return path_.string(); }

 private:
  fs::path path_;
};

void wait_s(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

void command(App& app, CommandKind kind, const char* text = "", float value = 0) {
  Command command;
  command.kind = kind;
  std::strcpy(command.text, text);
  command.value = value;
  command.p_WB = Vec3(3, 2, 1);
  command.yaw_rad = 0.5;
  (void)app.command(command);
}

// Nothing comes from either sensor for a while, then nothing from the cameras alone.
tools::Recording with_silences() {
  tools::Recording out = simulated(SimulatedDevice::kEuroc);
  const TimeNs begin = out.frames.front().t;
  const auto within = [begin](TimeNs t, double from_s, double to_s) {
    return t > begin + from_seconds(from_s) && t < begin + from_seconds(to_s);
  };
  out.imu.erase(std::remove_if(out.imu.begin(), out.imu.end(),
                               [&](const ImuSample& s) { return within(s.t, 1.9, 3.2); }),
                out.imu.end());
  out.frames.erase(std::remove_if(out.frames.begin(), out.frames.end(),
                                  [&](const auto& frame) {
                                    return within(frame.t, 1.85, 3.25) || within(frame.t, 4, 4.5);
                                  }),
                   out.frames.end());
  return out;
}

// Silences, a spike, commands that change the estimate: decisions of a run that depend on time and
// on how fast mapping was.
TEST(live, what_was_recorded_of_a_live_run_replays_to_the_same_bytes) {
  const Folder folder("pirvs_live_");
  ReplayOptions live;
  live.cores = 2;
  live.playback = Playback::kRealTime;
  live.faults = {"spike:1.2"};
  live.record = folder.path();
  live.while_it_runs = [](App& app) {
    wait_s(1.5);
    command(app, CommandKind::kSetParameter, "frontend.tracks_target", 120);
    wait_s(2.5);
    command(app, CommandKind::kSetPose);
    wait_s(1);
    command(app, CommandKind::kSetParameter, "no.such", 1);
    command(app, CommandKind::kReset);
  };
  const Replay run = replay(with_silences(), live);
  print("live", run);
  for (const char* lost : {"record_imu_dropped", "record_frame_dropped", "record_order_dropped",
                           "keyframes_dropped"}) {
    if (run.counter(lost) > 0) GTEST_SKIP() << lost << ": this machine cannot keep real time now";
  }
  EXPECT_GE(run.counter("imu_silent"), 1u);
  EXPECT_GE(run.counter("camera_silent"), 1u);
  const Replay again = replay(tools::open_recording(folder.path(), {}));
  print("replayed", again);
  EXPECT_GT(run.trajectory().size(), 1000u);
  EXPECT_TRUE(run.trajectory() == again.trajectory()) << "a replay differs from the live run";
  EXPECT_EQ(run.log.health.size(), again.log.health.size());
  for (const char* name : {"starts", "losses", "keyframes", "imu_silent", "camera_silent"}) {
    EXPECT_EQ(run.counter(name), again.counter(name)) << name;
  }
}

}  // namespace
}  // namespace pirvs::systems
