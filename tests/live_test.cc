// Recordings played as live sensors would: latency of poses, commands while it runs, and what was
// recorded of it replayed to the same bytes.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
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

// What else a device hears while it runs, from now on, every 100 ms.
void deliver_others(App& app, TimeNs begin, double from_s, double to_s) {
  for (double s = from_s; s < to_s; s += 0.1) {
    const TimeNs t = begin + from_seconds(s);
    GnssFix fix;
    fix.t = t;
    fix.latitude_deg = 47 + s * 1e-6 / 3;
    fix.v_ned = Vec3(s, 1 / (s + 1), -s);
    fix.type = GnssFixType::k3d;
    fix.has_velocity = true;
    EXPECT_EQ(app.deliver(arrival_of(fix)), Status::kOk);
    EXPECT_EQ(app.deliver(arrival_of(WheelSample{t, {s, -s / 7}, WheelKind::kLeftRight})),
              Status::kOk);
    EXPECT_EQ(app.deliver(arrival_of(bsp::GpioEdge{t, {4, 27}, true}, s < from_s + 0.1)),
              Status::kOk);
    wait_s(0.1);
  }
}

std::string content(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

// Not empty: this machine could not keep real time, and what.
std::string lost_by_the_recorder(const Replay& run) {
  for (const char* name : {"record_imu_dropped", "record_frame_dropped", "record_order_dropped",
                           "record_map_dropped"}) {
    if (run.counter(name) > 0) return name;
  }
  return "";
}

// But what the cameras refuse: nobody asks those of a replay.
std::string all_told(const Replay& run) {
  std::string out;
  for (const tools::HealthEvent& event : run.log.health) {
    if (event.what != "the cameras take no exposure and gain") out += event.what + "\n";
  }
  return out;
}

// Played again, and recorded while it is.
void expect_replays_to_the_same_bytes(const Replay& run, const std::string& recorded) {
  const Folder second("pirvs_again_");
  ReplayOptions options;
  options.record = second.path();
  const Replay again = replay(tools::open_recording(recorded, {}), options);
  print("replayed", again);
  EXPECT_GT(run.trajectory().size(), 1000u);
  EXPECT_TRUE(run.trajectory() == again.trajectory()) << "a replay differs from the live run";
  for (const char* file : {"/mav0/order.csv", "/mav0/maps.csv", "/mav0/imu0/data.csv"}) {
    EXPECT_TRUE(content(recorded + file) == content(second.path() + file)) << file;
  }
  EXPECT_EQ(all_told(run), all_told(again));
  for (const tools::Count& count : run.log.counters) {
    // How late the machine was, and nothing of the run.
    const bool of_time =
        count.name.rfind("overruns_", 0) == 0 || count.name.rfind("slips_", 0) == 0;
    if (of_time || count.name == "fused_states_missed") continue;
    EXPECT_EQ(count.value, again.counter(count.name)) << count.name;
  }
}

int told(const Replay& run, const std::string& what) {
  int count = 0;
  for (const tools::HealthEvent& event : run.log.health) count += event.what == what;
  return count;
}

// Silences, a spike, commands that change the estimate, fixes and edges: what a run depends on
// besides samples and frames, and how fast mapping was.
TEST(live, what_was_recorded_of_a_live_run_replays_to_the_same_bytes) {
  const Folder folder("pirvs_live_");
  tools::Recording recording = with_silences();
  recording.frames.at(20).lost_before = 3;
  ReplayOptions live;
  live.cores = 2;
  live.playback = Playback::kRealTime;
  live.faults = {"spike:1.2"};
  live.record = folder.path();
  live.while_it_runs = [&](App& app) {
    const TimeNs begin = recording.frames.front().t;
    wait_s(1.5);
    command(app, CommandKind::kSetParameter, "frontend.tracks_target", 120);
    deliver_others(app, begin, 1.5, 4);
    command(app, CommandKind::kSetPose);
    wait_s(1);
    command(app, CommandKind::kSetParameter, "no.such", 1);
    command(app, CommandKind::kReset);
  };
  const Replay run = replay(recording, live);
  print("live", run);
  const std::string lost = lost_by_the_recorder(run);
  if (!lost.empty()) GTEST_SKIP() << lost << ": this machine cannot keep real time now";
  EXPECT_GE(run.counter("imu_silent"), 1u);
  EXPECT_GE(run.counter("camera_silent"), 1u);
  EXPECT_EQ(run.counter("frames_lost"), 3u);
  EXPECT_EQ(run.counter("edges_lost"), 1u);
  const std::string order = content(folder.path() + "/mav0/order.csv");
  for (const char* row : {"\ngnss,", "\nwheel,", "\nedge,", "\ncommand,", "\ntick,"}) {
    EXPECT_NE(order.find(row), std::string::npos) << row;
  }
  expect_replays_to_the_same_bytes(run, folder.path());
}

// Mapping's results come so late that keyframes find no room: tracking drops them, in a replay the
// same ones.
TEST(live, a_run_with_mapping_far_behind_replays_to_the_same_bytes) {
  const Folder folder("pirvs_slow_");
  ReplayOptions live;
  live.cores = 2;
  live.playback = Playback::kRealTime;
  live.mapping_lag = MapGate::kLagMax;
  live.record = folder.path();
  live.while_it_runs = [](App& app) {
    wait_s(1);
    command(app, CommandKind::kSetParameter, "tracker.keyframe_distance_m", 0.01f);
    command(app, CommandKind::kSetParameter, "tracker.keyframe_interval_s_min", 0);
  };
  const Replay run = replay(simulated(SimulatedDevice::kEuroc), live);
  print("mapping behind", run);
  const std::string lost = lost_by_the_recorder(run);
  if (!lost.empty()) GTEST_SKIP() << lost << ": this machine cannot keep real time now";
  EXPECT_GT(run.counter("keyframes_dropped"), 10u);
  expect_replays_to_the_same_bytes(run, folder.path());
}

// The cameras are unplugged for three seconds, later the IMU for two, and their drivers say so.
// While frames wait for the IMU, the cameras' driver loses those that it has no buffer for.
TEST(live, sensors_that_are_lost_and_come_back_go_on_by_themselves) {
  const Folder folder("pirvs_lost_");
  tools::SimOptions options;
  options.duration_s = 10.5;
  options.path = "steady";  // the wall before the cameras stays in view
  options.blur = 2;
  tools::Recording recording = made(options, "lost");
  const TimeNs begin = recording.frames.front().t;
  const auto within = [begin](TimeNs t, double from_s, double to_s) {
    return t > begin + from_seconds(from_s) && t < begin + from_seconds(to_s);
  };
  auto& frames = recording.frames;
  auto& imu = recording.imu;
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [&](const auto& frame) { return within(frame.t, 2.5, 5.5); }),
               frames.end());
  imu.erase(std::remove_if(imu.begin(), imu.end(),
                           [&](const ImuSample& s) { return within(s.t, 6.5, 8.5); }),
            imu.end());
  const auto unbuffered = std::remove_if(
      frames.begin(), frames.end(), [&](const auto& frame) { return within(frame.t, 6.7, 8.4); });
  const auto frames_lost = static_cast<uint32_t>(frames.end() - unbuffered);
  frames.erase(unbuffered, frames.end());
  for (auto& frame : frames) {
    if (frame.t < begin + from_seconds(6.7)) continue;
    frame.lost_before = frames_lost;
    break;
  }
  ReplayOptions live;
  live.cores = 2;
  live.playback = Playback::kRealTime;
  live.record = folder.path();
  live.while_it_runs = [](App& app) {
    const auto say = [&app](ArrivalKind kind, Sensor sensor) {
      EXPECT_EQ(app.deliver(arrival_of(kind, sensor)), Status::kOk);
    };
    wait_s(2.8);
    say(ArrivalKind::kLost, Sensor::kCamera);
    wait_s(2.7);
    say(ArrivalKind::kBack, Sensor::kCamera);
    wait_s(1.3);
    say(ArrivalKind::kLost, Sensor::kImu);
    wait_s(1.7);
    say(ArrivalKind::kBack, Sensor::kImu);
  };
  const Replay run = replay(recording, live);
  print("lost and back", run);
  if (run.result.timing.back().mean > 25) {
    GTEST_SKIP() << "no real time: half a frame period is gone";
  }
  for (const char* name :
       {"camera_lost_device", "camera_back", "imu_lost_device", "imu_back", "imu_silent"}) {
    EXPECT_EQ(run.counter(name), 1u) << name;
  }
  for (const char* what : {"the cameras are lost", "the cameras are back", "the IMU is lost",
                           "the IMU is silent", "the IMU is back"}) {
    EXPECT_EQ(told(run, what), 1) << what;
  }
  EXPECT_EQ(run.counter("frames_lost"), frames_lost);
  EXPECT_EQ(told(run, "the cameras' driver loses frames"), 1);
  EXPECT_EQ(run.result.health_at_end, HealthState::kTracking);
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_LE(run.result.frames_lost, 20 + run.result.frames_dropped) << "a new start takes a second";
  EXPECT_LT(run.result.evaluation.ate_rmse_m, 0.1) << "it found its place in the old map";
  const std::string lost = lost_by_the_recorder(run);
  if (!lost.empty()) GTEST_SKIP() << lost << ": this machine cannot keep real time now";
  expect_replays_to_the_same_bytes(run, folder.path());
}

}  // namespace
}  // namespace pirvs::systems
