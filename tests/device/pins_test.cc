// The device's pins, seen from outside: what guest/robot.cc put on them and what it saw there.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "modules/door/command.h"
#include "tests/device/guest_run.h"
#include "tools/dataset/recording.h"

namespace pirvs::systems {
namespace {

constexpr TimeNs kMicro = 1'000, kMilli = 1'000'000;
constexpr TimeNs kFrame = 50 * kMilli;  // the recording's period

// How far each of `times` is from the nearest of `wanted`, sorted; both in order.
std::vector<TimeNs> distances(const std::vector<TimeNs>& times, const std::vector<TimeNs>& wanted) {
  std::vector<TimeNs> out;
  for (const TimeNs t : times) {
    const auto after = std::lower_bound(wanted.begin(), wanted.end(), t);
    TimeNs near = INT64_MAX;
    if (after != wanted.end()) near = std::min(near, *after - t);
    if (after != wanted.begin()) near = std::min(near, t - *(after - 1));
    out.push_back(near);
  }
  std::sort(out.begin(), out.end());
  return out;
}

void print(const char* what, const std::vector<TimeNs>& sorted) {
  const auto us = [&](double share) {
    return 1e-3 * double(sorted[size_t(share * double(sorted.size() - 1))]);
  };
  std::printf("%s, us: median %.1f, p99 %.1f, max %.1f, of %zu\n", what, us(0.5), us(0.99), us(1),
              sorted.size());
}

std::vector<TimeNs> frame_times(const DeviceRun& run) {
  std::vector<TimeNs> out;
  for (const auto& frame : fed_recording().frames) out.push_back(frame.t + run.shift);
  return out;
}

TEST(pins, sync_out_is_high_in_the_middle_of_each_exposure) {
  const DeviceRun& run = good_run(false);
  ASSERT_EQ(run.status, 0) << run.console;
  const std::vector<TimeNs> up = run.robot_times("SYNC_OUT", 1),
                            down = run.robot_times("SYNC_OUT", 0);
  const std::vector<TimeNs> exposures = frame_times(run);
  // The first few teach it the rhythm, and some come after the last frame, as long as it may still
  // be on its way.
  ASSERT_GE(up.size(), exposures.size() - 6);
  EXPECT_EQ(up.size(), run.counter("pin.sync_out_pulses"));
  EXPECT_EQ(run.counter("pin.sync_out_left_out"), 0u);
  std::vector<TimeNs> of_frames(up);
  while (!of_frames.empty() && of_frames.back() > exposures.back() + kFrame / 2)
    of_frames.pop_back();
  const std::vector<TimeNs> off = distances(of_frames, exposures);
  print("SYNC_OUT from mid-exposure", off);
  EXPECT_LT(off.back(), 50 * kMicro);
  EXPECT_LE(up.size() - of_frames.size(), 7u) << "pulses after the last frame";
  ASSERT_EQ(up.size(), down.size());
  for (size_t i = 0; i < up.size(); ++i) EXPECT_NEAR(double(down[i] - up[i]), 500e3, 100e3);
}

// A line `# sync_in T LEVEL [t x y z qx qy qz qw health confidence]`.
struct SyncLine {
  TimeNs t = 0;
  int words = 0;
  double x[3];
};

std::vector<SyncLine> sync_lines(const DeviceRun& run) {
  std::vector<SyncLine> out;
  std::istringstream all(run.lines);
  for (std::string line; std::getline(all, line);) {
    if (line.compare(0, 10, "# sync_in ") != 0) continue;
    long long s = 0, ns = 0;
    SyncLine one;
    double t = 0;
    int level = 0;
    if (std::sscanf(line.c_str(), "# sync_in %lld.%lld", &s, &ns) != 2) continue;
    one.t = s * 1'000'000'000 + ns;
    one.words = std::sscanf(line.c_str(), "# sync_in %*s %d %lf %lf %lf %lf", &level, &t, &one.x[0],
                            &one.x[1], &one.x[2]);
    out.push_back(one);
  }
  return out;
}

TEST(pins, sync_in_is_stamped_by_the_kernel_and_given_out_with_its_pose) {
  const DeviceRun& run = good_run(false);
  ASSERT_EQ(run.status, 0) << run.console;
  const std::vector<TimeNs> chosen = run.robot_times("sync");
  ASSERT_GT(chosen.size(), 90u);
  const std::vector<SyncLine> told = sync_lines(run);
  ASSERT_EQ(told.size(), chosen.size());
  EXPECT_EQ(run.counter("pin.sync_in_edges"), chosen.size());
  EXPECT_EQ(run.counter("pin.sync_in_lost"), 0u);
  std::vector<TimeNs> times;
  for (const SyncLine& line : told) times.push_back(line.t);
  const std::vector<TimeNs> off = distances(times, chosen);
  print("SYNC_IN from the time chosen", off);
  EXPECT_LT(off.back(), 20 * kMicro);
  // Poses of the frames around an edge contain the one at its time.
  std::map<TimeNs, double> x_of_frame;
  std::istringstream all(run.lines);
  for (std::string line; std::getline(all, line);) {
    double t = 0, x = 0;
    if (line[0] != '#' && std::sscanf(line.c_str(), "%lf %lf", &t, &x) == 2) {
      x_of_frame[static_cast<TimeNs>(t * 1e9)] = x;
    }
  }
  size_t with_pose = 0;
  for (const SyncLine& line : told) {
    if (line.words < 5) continue;
    ++with_pose;
    const auto after = x_of_frame.lower_bound(line.t);
    if (after == x_of_frame.end() || after == x_of_frame.begin()) continue;
    const auto before = std::prev(after);
    constexpr double kCorrection_m = 0.02;
    EXPECT_GT(line.x[0], std::min(before->second, after->second) - kCorrection_m);
    EXPECT_LT(line.x[0], std::max(before->second, after->second) + kCorrection_m);
  }
  EXPECT_GT(with_pose, 70u);
}

TEST(pins, a_wheel_turns_by_every_tick_and_is_recorded) {
  const DeviceRun& run = good_run(false);
  ASSERT_EQ(run.status, 0) << run.console;
  const std::vector<TimeNs> turned = run.robot_times("wheel");
  ASSERT_EQ(turned.size(), 1u);
  EXPECT_EQ(TimeNs(run.counter("pin.wheel_edges")), turned[0]);
  EXPECT_EQ(run.counter("pin.wheel_lost"), 0u);
  EXPECT_EQ(run.counter("pin.wheel_missed"), 0u);
  EXPECT_EQ(run.counter("pin.not_delivered"), 0u);
  // What the recorder was given of it before the run was stopped.
  std::istringstream order(text_of(run.folder + "/record/0001/mav0/order.csv"));
  double last = 0;
  size_t samples = 0, after_imu = 0;
  for (std::string line; std::getline(order, line);) {
    double left = 0, right = 0;
    if (line.compare(0, 4, "imu,") == 0) after_imu = 0;
    after_imu += line.compare(0, 6, "wheel,") == 0 || line.compare(0, 5, "edge,") == 0;
    if (std::sscanf(line.c_str(), "wheel,%*[^,],2,%lf,%lf", &left, &right) != 2) continue;
    EXPECT_GE(left, last);
    EXPECT_EQ(right, 0);
    last = left;
    ++samples;
  }
  EXPECT_GT(samples, 300u);
  EXPECT_NEAR(last, double(turned[0]), 100) << "ticks of the last 50 ms may be missing";
  // It turns for seconds before the IMU begins, which costs nothing of what comes later.
  EXPECT_GT(run.counter("aside_before_imu"), 16u);
  EXPECT_LE(run.counter("aside_full"), after_imu) << "but when the IMU has ended";
}

// Of the run with faults: dark images from frame 150 on, both cameras gone from frame 60 on.
TEST(pins, health_falls_within_a_frame_of_darkness_and_of_lost_cameras) {
  const DeviceRun& run = faulty_run(false);
  ASSERT_EQ(run.status, 0) << run.console;
  const std::vector<TimeNs> frames = frame_times(run);
  const std::vector<TimeNs> falls = run.robot_times("HEALTH", 0),
                            rises = run.robot_times("HEALTH", 1);
  std::printf("%s", run.pins.c_str());
  ASSERT_FALSE(rises.empty());
  EXPECT_LT(rises[0], frames[20]) << "it is good soon";
  const auto fall_after = [&](TimeNs t) {
    const auto found = std::lower_bound(falls.begin(), falls.end(), t);
    return found == falls.end() ? INT64_MAX : *found;
  };
  // A frame is there 5 ms after its exposure, and tracked one later.
  constexpr TimeNs kLatency = 40 * kMilli;
  const TimeNs lost = frames[60], dark = frames[150];
  std::printf(
      "HEALTH fell %.1f ms after the first frame that was lost, %.1f ms after the dark one\n",
      1e-6 * double(fall_after(lost) - lost), 1e-6 * double(fall_after(dark) - dark));
  EXPECT_LT(fall_after(lost), lost + kFrame + kLatency);
  EXPECT_LT(fall_after(dark), dark + kFrame + kLatency);
  EXPECT_GE(run.counter("pin.health_falls"), 2u);
  EXPECT_GT(rises.back(), lost) << "and it comes back";
}

TEST(pins, health_is_low_when_the_program_has_ended) {
  const DeviceRun& run = good_run(false);
  const std::vector<TimeNs> falls = run.robot_times("HEALTH", 0),
                            rises = run.robot_times("HEALTH", 1);
  ASSERT_FALSE(falls.empty());
  EXPECT_GT(falls.back(), rises.back());
}

}  // namespace
}  // namespace pirvs::systems
