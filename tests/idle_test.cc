// The whole stack while no sensor says anything: how often its cores wake, and what that costs.
#include <dirent.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "board/host/board.h"
#include "bsp/api/clock.h"
#include "bsp/replay/sensors.h"

namespace pirvs::systems {
namespace {

constexpr TimeNs kBegin = 1'000'000'000'000, kHour_ns = 3'600'000'000'000;
constexpr double kSettle_s = 0.5;  // until then threads start and the first sample is taken
constexpr double kMeasured_s = 3;

// One sample of the IMU, and nothing more within the hour.
struct Silence {
  bool first = true;

  bsp::RecordingSource source() {
    const auto imu = [](void* context, ImuSample& out) {
      out = ImuSample{};
      out.t =
          std::exchange(static_cast<Silence*>(context)->first, false) ? kBegin : kBegin + kHour_ns;
      out.f_B.z() = 9.81;
      return true;
    };
    const auto frame = [](void*, StereoFrame& out) {
      out.t = kBegin + kHour_ns;
      return true;
    };
    return {this, imu, frame, [](void*, FrameId) {}};
  }
};

// How often each thread of this process has gone to sleep, by its name in /proc.
std::map<std::string, long> sleeps() {
  std::map<std::string, long> out;
  DIR* const folder = opendir("/proc/self/task");
  while (const dirent* const entry = readdir(folder)) {
    if (entry->d_name[0] == '.') continue;
    const std::string thread = entry->d_name;
    std::ifstream status("/proc/self/task/" + thread + "/status");
    for (std::string line; std::getline(status, line);) {
      constexpr char kVoluntary[] = "voluntary_ctxt_switches:";
      if (line.rfind(kVoluntary, 0) == 0) out[thread] = std::stol(line.substr(sizeof kVoluntary));
    }
  }
  closedir(folder);
  return out;
}

double cpu_s() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Rest {
  double wakes_hz_max = 0;  // of a core
  int cores = 0;            // that woke at all
  double cpu_share = 0;
};

void sleep_s(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

Rest measure() {
  sleep_s(kSettle_s);
  const auto before = sleeps();
  const double cpu_before = cpu_s();
  const TimeNs begin = bsp::now();
  sleep_s(kMeasured_s);
  const double s = to_seconds(bsp::now() - begin);
  Rest out;
  out.cpu_share = (cpu_s() - cpu_before) / s;
  for (const auto& [thread, count] : sleeps()) {
    const double wakes_hz = double(count - before.at(thread)) / s;
    std::printf("thread %s: %.1f wakes a second\n", thread.c_str(), wakes_hz);
    out.wakes_hz_max = std::max(out.wakes_hz_max, wakes_hz);
    if (wakes_hz > 10) ++out.cores;
  }
  std::printf("%d cores, CPU %.2f %%\n", out.cores, 100 * out.cpu_share);
  return out;
}

TEST(idle, wakes_fewer_than_50_times_a_second_and_costs_less_than_1_percent) {
  const auto app = std::make_unique<App>();
  Calibration calibration;
  for (Camera& camera : calibration.camera) {
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 400;
  }
  app->configure(calibration, AppParams{}, AppSinks{});
  Silence silence;
  bsp::play(silence.source(), bsp::ReplayPace::kRealTime);
  app->set_clock(bsp::replay_now);
  Rest rest;
  std::thread other([&] {
    rest = measure();
    Command stop;
    stop.kind = CommandKind::kStop;
    EXPECT_TRUE(app->command(stop).ok());
  });
  EXPECT_EQ(app->run(board::kPlans[1], Drive::kTimed), Status::kBadData) << "it never started";
  other.join();
  EXPECT_EQ(rest.cores, 2);
  EXPECT_LT(rest.wakes_hz_max, 50);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(rest.cpu_share, 0.01);
#endif
}

}  // namespace
}  // namespace pirvs::systems
