// What goes in by device nodes comes out as the replay of it: cameras by V4L2, the IMU by IIO.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/device/guest_run.h"
#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

// A count of each IMU: inv_mpu6050 at 2 g and 2000 deg/s, the ICM-20602 at 8 g and 2000 deg/s.
struct Counts {
  double force, rate;
};
constexpr Counts kMpu6500 = {0.000598, 0.001064724};
constexpr Counts kIcm20602 = {8.0 / 32768 * 9.80665, 2000.0 / 32768 * 3.14159265358979323846 / 180};

double in_counts(double value, double scale) {
  return static_cast<double>(std::lround(value / scale)) * scale;
}

// Of both ways of the IMU: the kernel's driver, and our own over I2C.
class device : public testing::TestWithParam<bool> {
 protected:
  static const tools::Recording& fed() { return fed_recording(); }
  static const DeviceRun& run() { return good_run(GetParam()); }
  static const tools::Recording& sensed() {
    static std::map<bool, tools::Recording> both;
    const auto found = both.find(GetParam());
    if (found != both.end()) return found->second;
    return both[GetParam()] = tools::open_recording(run().folder + "/record/0001", {});
  }
};

// The first eight words of each line.
std::string poses_of(const std::string& lines) {
  std::string out;
  std::istringstream all(lines);
  for (std::string line; std::getline(all, line);) {
    if (line[0] == '#') continue;  // an edge of SYNC_IN
    size_t end = 0;
    for (int word = 0; word < 8 && end != std::string::npos; ++word) {
      end = line.find(' ', end + (word > 0));
    }
    out += line.substr(0, end) + "\n";
  }
  return out;
}

TEST_P(device, takes_every_image_and_sample_and_ends_in_order) {
  const DeviceRun& got = run();
  ASSERT_EQ(got.status, 0) << got.console;
  std::printf("%s%s", got.fed.c_str(), got.news.c_str());
  EXPECT_TRUE(got.says("pirvsd ended with 0")) << got.console;
  EXPECT_NE(got.fed.find(" 0 refused, 0 clipped"), std::string::npos) << got.fed;
  const size_t frames = fed().frames.size(), samples = fed().imu.size();
  EXPECT_EQ(got.counter("camera.left.images"), frames);
  EXPECT_EQ(got.counter("camera.right.images"), frames);
  EXPECT_EQ(got.counter("cameras.pairs"), frames);
  EXPECT_EQ(got.counter("imu.samples"), samples);
  for (const char* none :
       {"camera.left.lost", "camera.right.lost", "camera.left.damaged", "camera.left.stale",
        "camera.left.unstamped", "camera.left.converted", "camera.right.converted",
        "cameras.halves", "cameras.counts_wrong", "imu.lost", "imu.wrong_clock", "output.dropped",
        "frame_backwards", "imu_gap", "imu_backwards"}) {
    EXPECT_EQ(got.counter(none), 0u) << none;
  }
  EXPECT_LE(got.counter("frame_before_imu"), 1u) << "the first: cameras have been silent";
  EXPECT_EQ(got.counter("output.lines"),
            got.counter("frames_with_pose") + got.counter("pin.sync_in_edges"));
  EXPECT_GE(got.counter("output.datagrams"), 9 * got.counter("frames_with_pose"));
  EXPECT_GT(got.counter("heap.calls"), 0u) << "libgpiod's, at start";
  EXPECT_EQ(got.counter("heap.calls_after_start"), 0u);
}

// What the recorder was given is what was fed: stamps but for the microseconds that V4L2 cuts off
// and the time that the interrupt took, values in the driver's counts.
TEST_P(device, senses_what_was_fed) {
  ASSERT_EQ(run().status, 0);
  constexpr TimeNs kLate_max = 20'000;
  const Counts counts = GetParam() ? kIcm20602 : kMpu6500;
  ASSERT_EQ(sensed().imu.size(), fed().imu.size());
  TimeNs late_max = 0;
  for (size_t i = 0; i < fed().imu.size(); ++i) {
    const ImuSample &in = fed().imu[i], &out = sensed().imu[i];
    const TimeNs late = out.t - in.t - run().shift;
    ASSERT_GE(late, 0) << i;
    late_max = std::max(late_max, late);
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(out.f_B(k), in_counts(in.f_B(k), counts.force)) << i;
      ASSERT_EQ(out.w_B(k), in_counts(in.w_B(k), counts.rate)) << i;
    }
  }
  std::printf("samples are stamped %.1f us late at most\n", 1e-3 * double(late_max));
  EXPECT_LT(late_max, kLate_max);
  ASSERT_EQ(sensed().frames.size(), fed().frames.size());
  for (size_t i = 0; i < fed().frames.size(); ++i) {
    const tools::FrameFiles &in = fed().frames[i], &out = sensed().frames[i];
    ASSERT_EQ(out.t, (in.t + run().shift) / 1000 * 1000) << i;
    for (int c = 0; c < 2; ++c) {
      const cv::Mat before = cv::imread(in.image[c], cv::IMREAD_GRAYSCALE);
      const cv::Mat after = cv::imread(out.image[c], cv::IMREAD_GRAYSCALE);
      ASSERT_EQ(before.size(), after.size());
      ASSERT_EQ(cv::norm(before, after, cv::NORM_L1), 0) << i << ", camera " << c;
    }
  }
}

// Same code, same input, another processor.
TEST_P(device, what_it_recorded_replays_to_the_bytes_it_gave_out) {
  ASSERT_EQ(run().status, 0);
  const Replay host = replay(sensed());
  print("replay of the device's recording", host);
  const std::string poses = poses_of(run().lines);
  EXPECT_GT(std::count(poses.begin(), poses.end(), '\n'), 100);
  EXPECT_TRUE(poses == host.trajectory()) << "another trajectory than the device's";
}

struct Difference {
  size_t poses = 0;
  double rms_m = 0, max_m = 0;
};

// Of positions at the same frames; theirs are `shift` earlier.
Difference difference(const Replay& ours, const Replay& theirs, TimeNs shift) {
  Difference out;
  std::map<TimeNs, Vec3> places;
  for (const auto& pose : theirs.result.trajectory.poses) {
    places[(pose.t + shift) / 1000] = pose.p_WB;
  }
  for (const auto& pose : ours.result.trajectory.poses) {
    const auto found = places.find(pose.t / 1000);
    if (found == places.end()) continue;
    const double off_m = (found->second - pose.p_WB).norm();
    out.rms_m += off_m * off_m;
    out.max_m = std::max(out.max_m, off_m);
    ++out.poses;
  }
  out.rms_m = std::sqrt(out.rms_m / std::max(1.0, double(out.poses)));
  return out;
}

// The same arrivals and the same results of mapping at the same frames, but the times that were fed
// instead of those that V4L2 and the interrupt made of them. A simulated flight has a sample at
// each frame's time, to the nanosecond; a device must interpolate one there. Microseconds cost far
// less than this allows: gates and the choice of a track's template may decide otherwise.
TEST_P(device, stamps_cost_some_millimetres_at_most) {
  ASSERT_EQ(run().status, 0);
  const double near_m = clip() != nullptr ? 2.5e-3 : 5e-3;
  tools::Recording exact = sensed();
  for (size_t i = 0; i < exact.imu.size(); ++i) exact.imu[i].t = fed().imu[i].t + run().shift;
  for (size_t i = 0; i < exact.frames.size(); ++i) {
    exact.frames[i].t = fed().frames[i].t + run().shift;
  }
  const Difference off = difference(replay(sensed()), replay(exact), 0);
  std::printf("%zu poses, off by %.6f m rms, %.6f m at most\n", off.poses, off.rms_m, off.max_m);
  EXPECT_GT(off.poses, 90u);
  EXPECT_LT(off.rms_m, near_m);
  EXPECT_LT(off.max_m, 2 * near_m);
}

// Against the replay of what was fed, without the first frame: live, the IMU does not wait for
// cameras that have been silent. Mapping's results reach a frame when its core has had the time;
// replays that delay them by 0 to 3 frames are as far from each other.
TEST_P(device, tracks_as_a_replay_does) {
  ASSERT_EQ(run().status, 0);
  constexpr double kNear_m = 5e-3;
  tools::Recording rest = fed();
  rest.frames.erase(rest.frames.begin());
  const Replay ours = replay(sensed()), theirs = replay(rest);
  const Difference off = difference(ours, theirs, run().shift);
  std::printf("%zu poses, off by %.5f m rms, %.5f m at most\n", off.poses, off.rms_m, off.max_m);
  EXPECT_EQ(off.poses, theirs.result.trajectory.poses.size());
  EXPECT_LT(off.rms_m, kNear_m);
}

INSTANTIATE_TEST_SUITE_P(imu, device, testing::Bool(), [](const auto& info) {
  return std::string(info.param ? "icm20602" : "mpu6500");
});

// What guest/feeder.cc lists: a stale image of one camera at the start, half pairs, a pair lost,
// both cameras pulled and plugged in, the IMU likewise, one camera stalled while its node stays.
TEST(device_faults, are_survived_and_counted) {
  const DeviceRun& got = faulty_run(false);
  ASSERT_EQ(got.status, 0) << got.console;
  std::printf("%s%s", got.fed.c_str(), got.news.c_str());
  EXPECT_TRUE(got.says("pirvsd ended with 0")) << got.console;
  const std::map<std::string, uint64_t> kCounted = {
      {"camera.left.stale", 0},     {"camera.right.stale", 1},
      {"camera.left.damaged", 1},   {"camera.right.damaged", 0},
      {"camera.left.unplugged", 1}, {"camera.right.unplugged", 1},
      {"camera.left.opened", 2},    {"camera.right.opened", 2},
      {"cameras.counts_found", 3},  {"camera.left.stalled", 1},
      {"camera.right.stalled", 0},  {"cameras.counts_wrong", 0},
      {"imu.unplugged", 1},         {"imu.opened", 2},
      {"camera_back", 1},           {"output.dropped", 0},
  };
  for (const auto& [name, value] : kCounted) EXPECT_EQ(got.counter(name), value) << name;
  // Those of the pulses that were left out, and what the cameras had no buffer for while the door
  // held a frame for the IMU that was away.
  EXPECT_GE(got.counter("camera.left.lost"), 1u);
  EXPECT_LE(got.counter("camera.left.lost"), 10u);
  EXPECT_LE(got.counter("camera.right.lost"), 11u) << "and half a pair";
  // Both were away for 16 frames and up to kRetry_ns more, the IMU for 6 and as long, the left one
  // for the 2 s after its last image in which a camera is not yet taken to stall.
  const size_t frames = fed_recording().frames.size();
  constexpr size_t kStalled = 40, kTakenLate = 12;  // it was held up for the IMU
  EXPECT_GE(got.counter("cameras.pairs"), frames - 30 - kStalled - kTakenLate);
  EXPECT_LE(got.counter("cameras.pairs"), frames - 19 - kStalled + 2);
  EXPECT_GE(got.counter("cameras.halves"), kStalled);
  EXPECT_LE(got.counter("cameras.halves"), 2 + kStalled + kTakenLate);
  EXPECT_GE(got.counter("imu.samples"), fed_recording().imu.size() - 200);
  for (const char* told :
       {"/dev/video0: camera unplugged, waiting for it",
        "/dev/video1: camera unplugged, waiting for it",
        "/dev/video0: camera stalled, its stream is started anew",
        "/dev/video0: camera gives images again", "iio:mpu6500: IMU unplugged, waiting for it"}) {
    EXPECT_TRUE(got.says(told)) << told;
  }
  EXPECT_GT(got.counter("output.lines"), frames / 3) << "it goes on";
}

// What guest/feeder.cc lists of the chip on I2C: a bus that is dead for 30 ms and for 0.6 s, so
// that its FIFO runs over, a brown-out, lost interrupts; beside that the clock is set, and memory
// and disk run out.
TEST(device_faults, of_the_chip_and_of_the_machine_are_survived_and_counted) {
  const DeviceRun& got = faulty_run(true);
  ASSERT_EQ(got.status, 0) << got.console;
  std::printf("%s%s%s", got.fed.c_str(), got.news.c_str(),
              text_of(got.folder + "/trouble").c_str());
  EXPECT_TRUE(got.says("pirvsd ended with 0")) << got.console;
  EXPECT_GE(got.counter("imu.bus_errors"), 1u);
  EXPECT_GE(got.counter("imu.silent"), 2u) << "after a brown-out it sleeps, and lost interrupts";
  EXPECT_GE(got.counter("imu.unplugged"), 1u) << "0.6 s without an answer";
  EXPECT_GE(got.counter("imu.samples"), fed_recording().imu.size() / 2);
  EXPECT_TRUE(got.says("data-ready edges are missing: setting the IMU up anew"));
  EXPECT_TRUE(got.says("LEFT_A: the pin is busy"));
  const std::string kernel = text_of(got.folder + "/kernel");
  EXPECT_NE(kernel.find("Out of memory: Killed process"), std::string::npos);
  EXPECT_EQ(kernel.find("(pirvsd)"), std::string::npos) << "the other one was killed";
  EXPECT_EQ(got.counter("heap.calls_after_start"), 0u);
  EXPECT_GT(got.counter("output.lines"), fed_recording().frames.size() / 4) << "it goes on";
}

}  // namespace
}  // namespace pirvs::systems
