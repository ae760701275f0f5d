#include "tools/run/fault.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr TimeNs kBegin = 1'500'000'000'000'000'000;
constexpr TimeNs kFrame = 50'000'000, kImu = 5'000'000;
constexpr int kFrames = 100, kImuSamples = 1000;

Recording make_recording() {
  Recording recording;
  for (int i = 0; i < kFrames; ++i) {
    FrameFiles frame;
    frame.t = kBegin + i * kFrame;
    recording.frames.push_back(frame);
  }
  return recording;
}

// Sends a whole recording through; image c of frame i is flat, of grey i + 100 c.
struct Played {
  std::vector<StereoFrame> frames;
  std::vector<int> grey[2];  // -1: missing, -2: not flat
  std::vector<ImuSample> imu;
  size_t applied = 0;

  explicit Played(const std::vector<std::string>& specs) {
    std::vector<Fault> faults;
    for (const std::string& spec : specs) faults.push_back(parse_fault(spec));
    FaultLine line(faults, make_recording());
    for (int i = 0; i < kFrames; ++i) {
      std::vector<uint8_t> pixels[2];
      StereoFrame frame;
      frame.t = kBegin + i * kFrame;
      frame.present = 3;
      for (int c = 0; c < 2; ++c) {
        pixels[c].assign(12, uint8_t(i + 100 * c));
        frame.image[c] = {pixels[c].data(), 4, 3, 4};
      }
      if (!line.pass(frame)) continue;
      frames.push_back(frame);
      for (int c = 0; c < 2; ++c) grey[c].push_back(flat(frame, c));
    }
    for (int i = 0; i < kImuSamples; ++i) {
      ImuSample sample{kBegin + i * kImu, Vec3(0.001 * i, -0.1, 0.1), Vec3(0.1, 0.2, -9.8)};
      if (line.pass(sample)) imu.push_back(sample);
    }
    for (const Count& count : line.applied()) applied += count.value;
  }
  static int flat(const StereoFrame& frame, int c) {
    if ((frame.present >> c & 1) == 0) return -1;
    const ImageView& image = frame.image[c];
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        if (image.row(y)[x] != image.row(0)[0]) return -2;
      }
    }
    return image.row(0)[0];
  }
};

TEST(fault_line, without_faults_changes_nothing) {
  const Played played({});
  ASSERT_EQ(played.frames.size(), size_t(kFrames));
  ASSERT_EQ(played.imu.size(), size_t(kImuSamples));
  for (int i = 0; i < kFrames; ++i) EXPECT_EQ(played.grey[1][size_t(i)], i + 100);
  EXPECT_EQ(played.applied, 0u);
}

TEST(fault_line, cameras_fall_silent_and_return) {
  const Played played({"cam0:1-2", "cam1:1.5-3"});
  for (int i = 0; i < kFrames; ++i) {
    EXPECT_EQ(played.grey[0][size_t(i)] == -1, i >= 20 && i < 40) << i;
    EXPECT_EQ(played.grey[1][size_t(i)] == -1, i >= 30 && i < 60) << i;
  }
  EXPECT_EQ(played.applied, 20u + 30u);
}

TEST(fault_line, pixels) {
  const Played played({"black:0.5-0.6", "white:1-1.1", "frozen:2-2.2", "gain:4x2"});
  for (size_t i = 0; i < kFrames; ++i) {
    for (int c = 0; c < 2; ++c) {
      const int own = int(i) + 100 * c;
      const int expected = i == 10 || i == 11   ? 0
                           : i == 20 || i == 21 ? 255
                           : i >= 40 && i < 44  ? 39 + 100 * c
                           : i >= 80            ? std::min(255, 2 * own)
                                                : own;
      EXPECT_EQ(played.grey[c][i], expected) << i;
    }
  }
}

TEST(fault_line, the_right_camera_is_late_by_a_frame) {
  const Played once({"late:1"});
  const Played twice({"late:1-1.1"});
  for (size_t i = 0; i < kFrames; ++i) {
    const bool late_once = i == 20, late_twice = i == 20 || i == 21;
    EXPECT_EQ(once.grey[0][i], int(i));
    EXPECT_EQ(once.grey[1][i], int(i) + 100 - (late_once ? 1 : 0));
    EXPECT_EQ(once.frames[i].late[1], late_once ? kFrame : 0);
    EXPECT_EQ(twice.grey[1][i], int(i) + 100 - (late_twice ? 1 : 0));
    EXPECT_EQ(twice.frames[i].late[1], late_twice ? kFrame : 0);
  }
}

TEST(fault_line, frames_are_lost_at_random_but_the_same_every_time) {
  const Played a({"frames:0.1"}), b({"frames:0.1"});
  EXPECT_GT(a.frames.size(), 80u);
  EXPECT_LT(a.frames.size(), 97u);
  EXPECT_EQ(a.grey[0], b.grey[0]);
  EXPECT_TRUE(Played({"frames:1"}).frames.empty());
  EXPECT_EQ(Played({"frames:0"}).frames.size(), size_t(kFrames));
}

TEST(fault_line, imu) {
  EXPECT_EQ(Played({"imu:1-1.1"}).imu.size(), size_t(kImuSamples) - 20);
  const Played played({"nan:1", "spike:2", "saturate:3-3.1", "stuck:4-4.5"});
  ASSERT_EQ(played.imu.size(), size_t(kImuSamples));
  int nan = 0, spikes = 0, full = 0, stuck = 0;
  for (size_t i = 0; i < played.imu.size(); ++i) {
    const ImuSample& s = played.imu[i];
    nan += std::isnan(s.w_B.x()) && std::isnan(s.f_B.z());
    spikes += s.w_B.x() == 30 && s.f_B.z() == -150;
    full += s.w_B.y() < -30 && s.f_B.z() < -150 && s.f_B.x() > 150;
    stuck += i > 0 && s.w_B.x() == played.imu[i - 1].w_B.x();
  }
  EXPECT_EQ(nan, 1);
  EXPECT_EQ(spikes, 1);
  EXPECT_EQ(full, 20);
  EXPECT_GE(stuck, 100);
  EXPECT_EQ(played.applied, 1u + 1u + 20u + 100u);
}

TEST(fault_line, stamps_and_clocks) {
  const Played stamp({"stamp:1"});
  for (size_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(stamp.frames[i].t, kBegin + TimeNs(i) * kFrame - (i == 20 ? 100'000'000 : 0));
  }
  EXPECT_EQ(stamp.imu[200].t, kBegin + 200 * kImu - 100'000'000);
  EXPECT_EQ(stamp.imu[201].t, kBegin + 201 * kImu);
  const Played both({"clock:1x5"}), imu({"clock-imu:1x-2"}), cam({"clock-cam:1x0.5"});
  EXPECT_EQ(both.frames[20].t, kBegin + 20 * kFrame + from_seconds(5));
  EXPECT_EQ(both.imu[199].t, kBegin + 199 * kImu);
  EXPECT_EQ(both.imu[200].t, kBegin + 200 * kImu + from_seconds(5));
  EXPECT_EQ(imu.imu[999].t, kBegin + 999 * kImu - from_seconds(2));
  EXPECT_EQ(imu.frames[99].t, kBegin + 99 * kFrame);
  EXPECT_EQ(cam.frames[99].t, kBegin + 99 * kFrame + from_seconds(0.5));
  EXPECT_EQ(cam.imu[999].t, kBegin + 999 * kImu);
}

TEST(fault_spec, what_makes_no_sense_is_refused_in_one_line) {
  const char* const cases[][2] = {{"", "no such fault"},
                                  {"cam2:1-2", "there are: cam0 cam1"},
                                  {"black", "needs a time"},
                                  {"black:", "not in seconds"},
                                  {"black:x", "not in seconds"},
                                  {"black:-1-2", "not in seconds"},
                                  {"black:2-1", "does not end"},
                                  {"black:1-1", "does not end"},
                                  {"black:1-", "does not end"},
                                  {"black:1-2-3", "does not end"},
                                  {"nan:0-8e-87", "does not end"},
                                  {"nan:1--2", "does not end"},
                                  {"black:nan", "not in seconds"},
                                  {"black:1e9", "not in seconds"},
                                  {"gain:18", "behind 'x'"},
                                  {"gain:18x", "not within 0.01 to 100"},
                                  {"gain:18x0", "not within"},
                                  {"frames:1.5", "not within 0 to 1"},
                                  {"frames:-0", "ok"},
                                  {"clock:12x-5", "ok"},
                                  {"gain:18-20x4", "ok"},
                                  {"late:8", "ok"}};
  for (const auto& [spec, says] : cases) {
    std::string said = "ok";
    try {
      (void)parse_fault(spec);
    } catch (const InputError& error) {
      said = error.what();
    }
    EXPECT_NE(said.find(says), std::string::npos) << spec << ": " << said;
    EXPECT_EQ(said.find('\n'), std::string::npos);
  }
}

TEST(fault_spec, one_that_cannot_happen_is_refused) {
  EXPECT_THROW(FaultLine({parse_fault("black:5-6")}, make_recording()), InputError);
  EXPECT_NO_THROW(FaultLine({parse_fault("black:4.9-6")}, make_recording()));
}

TEST(fault_spec, the_help_shows_every_kind_with_an_example_that_parses) {
  const std::string help = fault_help();
  size_t kinds = 0;
  for (size_t at = help.find("\n  "); at != std::string::npos; at = help.find("\n  ", at + 1)) {
    const std::string example = help.substr(at + 3, help.find(' ', at + 3) - at - 3);
    EXPECT_EQ(size_t(parse_fault(example).kind), kinds++) << example;
  }
  EXPECT_EQ(kinds, size_t(FaultKind::kCount));
}

}  // namespace
}  // namespace pirvs::tools
