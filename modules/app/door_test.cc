#include "modules/app/door.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "bsp/replay/replay.h"

namespace pirvs {
namespace {

constexpr TimeNs kMs = 1'000'000;

// A recording made of lists, played by the replay backend.
struct Script {
  explicit Script(TimeNs offset = 0) {
    bsp::replay_start({this, next_imu, next_frame, release}, bsp::ReplayPace::kFast);
    door.configure(offset);
  }
  // Rates and forces that are linear in time, so that interpolation is exact.
  void imu(TimeNs t) {
    const double s = to_seconds(t);
    samples.push_back({t, Vec3(s, 2 * s, -s), Vec3(10 * s, 1, 9.81)});
  }
  void imu_until(TimeNs begin, TimeNs end) {
    for (TimeNs t = begin; t <= end; t += 5 * kMs) imu(t);
  }
  void frame(TimeNs t, uint8_t present = 3) {
    StereoFrame f;
    f.t = t;
    f.present = present;
    frames.push_back(f);
  }
  static bool next_imu(void* context, ImuSample& out) {
    Script& s = *static_cast<Script*>(context);
    if (s.imu_at == s.samples.size()) return false;
    out = s.samples[s.imu_at++];
    return true;
  }
  static bool next_frame(void* context, StereoFrame& out) {
    Script& s = *static_cast<Script*>(context);
    if (s.frame_at == s.frames.size()) return false;
    out = s.frames[s.frame_at++];
    return true;
  }
  static void release(void* context) { ++static_cast<Script*>(context)->released; }

  // Everything that the door hands out until the end of the streams.
  std::vector<DoorItem> all() {
    std::vector<DoorItem> items;
    for (int guard = 0; guard < 10'000; ++guard) {
      DoorItem item;
      const Status status = door.next(item);
      if (status == Status::kStale) return items;
      EXPECT_EQ(status, Status::kOk);
      if (status != Status::kOk) return items;
      items.push_back(item);
      if (item.is_frame) door.release();
    }
    ADD_FAILURE() << "the door never ends";
    return items;
  }
  uint32_t lost(DoorLoss loss) const { return door.losses()[static_cast<int>(loss)]; }
  uint32_t lost() const {
    uint32_t sum = 0;
    for (int i = 0; i < static_cast<int>(DoorLoss::kCount); ++i) sum += door.losses()[i];
    return sum;
  }

  std::vector<ImuSample> samples;
  std::vector<StereoFrame> frames;
  size_t imu_at = 0, frame_at = 0;
  int released = 0;
  Door door;
};

TimeNs time_of(const DoorItem& item) { return item.is_frame ? item.frame.t : item.imu.t; }

std::vector<TimeNs> frame_times(const std::vector<DoorItem>& items) {
  std::vector<TimeNs> out;
  for (const DoorItem& item : items) {
    if (item.is_frame) out.push_back(item.frame.t);
  }
  return out;
}

TEST(door, one_stream_in_order_with_a_sample_at_every_frame) {
  Script s;
  s.imu_until(0, 200 * kMs);
  for (TimeNs t = 12 * kMs; t < 190 * kMs; t += 33 * kMs) s.frame(t);
  const std::vector<DoorItem> items = s.all();
  ASSERT_EQ(frame_times(items).size(), 6u);
  for (size_t i = 1; i < items.size(); ++i) {
    if (items[i].is_frame) {
      ASSERT_FALSE(items[i - 1].is_frame);
      EXPECT_EQ(time_of(items[i]), items[i - 1].imu.t);
    } else if (!items[i - 1].is_frame) {
      EXPECT_GT(time_of(items[i]), time_of(items[i - 1]));
    }
  }
  EXPECT_EQ(items.size(), 41u + 6u + 5u) << "one frame lies on a sample, five get theirs";
  EXPECT_EQ(s.lost(), 0u);
  EXPECT_EQ(s.released, 6);
}

TEST(door, interpolates_at_the_time_of_the_frame) {
  Script s;
  s.imu_until(0, 50 * kMs);
  s.frame(22 * kMs);
  s.frame(23 * kMs);
  for (const DoorItem& item : s.all()) {
    if (item.is_frame) continue;
    const double t = to_seconds(item.imu.t);
    EXPECT_LT((item.imu.w_B - Vec3(t, 2 * t, -t)).norm(), 1e-12);
    EXPECT_LT((item.imu.f_B - Vec3(10 * t, 1, 9.81)).norm(), 1e-12);
  }
}

TEST(door, a_sample_at_the_frame_serves_as_it_is) {
  Script s;
  s.imu_until(0, 50 * kMs);
  s.frame(0);
  s.frame(20 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(items.size(), 11u + 2u);
  EXPECT_FALSE(items[0].is_frame);
  EXPECT_TRUE(items[1].is_frame) << "the first sample lies at the first frame";
}

TEST(door, camera_stamps_move_to_the_clock_of_the_imu) {
  Script s(-7 * kMs);
  s.imu_until(0, 50 * kMs);
  s.frame(27 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(frame_times(items), std::vector<TimeNs>{20 * kMs});
}

TEST(door, drops_samples_that_are_not_finite) {
  Script s;
  s.imu_until(0, 50 * kMs);
  s.samples[3].w_B.y() = std::numeric_limits<double>::quiet_NaN();
  s.samples[4].f_B.z() = std::numeric_limits<double>::infinity();
  s.frame(40 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kImuNotFinite), 2u);
  EXPECT_EQ(items.size(), 9u + 1u);
  for (const DoorItem& item : items) {
    EXPECT_TRUE(item.imu.w_B.allFinite() && item.imu.f_B.allFinite());
  }
}

TEST(door, drops_what_goes_backwards_in_time) {
  Script s;
  s.imu_until(0, 20 * kMs);
  s.imu(15 * kMs);  // back
  s.imu(20 * kMs);  // the same again
  s.imu_until(25 * kMs, 60 * kMs);
  s.frame(30 * kMs);
  s.frame(10 * kMs);
  s.frame(30 * kMs);
  s.frame(50 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kImuBackwards), 2u);
  EXPECT_EQ(s.lost(DoorLoss::kFrameBackwards), 2u);
  EXPECT_EQ(frame_times(items), (std::vector<TimeNs>{30 * kMs, 50 * kMs}));
  for (size_t i = 1; i < items.size(); ++i) EXPECT_GE(time_of(items[i]), time_of(items[i - 1]));
}

TEST(door, counts_a_gap_and_bridges_it) {
  Script s;
  s.imu_until(0, 20 * kMs);
  s.imu_until(170 * kMs, 200 * kMs);
  s.frame(100 * kMs);
  s.frame(150 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kImuGap), 1u) << "once, though two frames lie in it";
  EXPECT_EQ(frame_times(items), (std::vector<TimeNs>{100 * kMs, 150 * kMs}));
}

TEST(door, frames_before_the_imu_are_dropped) {
  Script s;
  s.frame(10 * kMs);
  s.frame(40 * kMs);
  s.frame(70 * kMs);
  s.imu_until(50 * kMs, 100 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kFrameBeforeImu), 2u);
  EXPECT_EQ(frame_times(items), std::vector<TimeNs>{70 * kMs});
  EXPECT_EQ(s.released, 3) << "dropped ones are given back too";
}

TEST(door, frames_after_the_imu_are_dropped) {
  Script s;
  s.imu_until(0, 50 * kMs);
  s.frame(30 * kMs);
  s.frame(60 * kMs);
  s.frame(90 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kFrameWithoutImu), 2u);
  EXPECT_EQ(frame_times(items), std::vector<TimeNs>{30 * kMs});
  EXPECT_EQ(s.released, 3);
}

TEST(door, one_camera_missing_passes_both_missing_does_not) {
  Script s;
  s.imu_until(0, 100 * kMs);
  s.frame(20 * kMs, 1);
  s.frame(40 * kMs, 0);
  s.frame(60 * kMs, 2);
  s.frame(80 * kMs, 3);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kCameraMissing), 3u);
  EXPECT_EQ(frame_times(items), (std::vector<TimeNs>{20 * kMs, 60 * kMs, 80 * kMs}));
}

TEST(door, the_end_is_stale_and_stays_so) {
  Script s;
  s.imu_until(0, 20 * kMs);
  s.frame(10 * kMs);
  EXPECT_EQ(s.all().size(), 6u) << "samples after the last frame come out as well";
  DoorItem item;
  EXPECT_EQ(s.door.next(item), Status::kStale);
  EXPECT_EQ(s.door.next(item), Status::kStale);
}

TEST(door, nothing_at_all_ends_at_once) {
  Script s;
  DoorItem item;
  EXPECT_EQ(s.door.next(item), Status::kStale);
}

TEST(door, a_frame_stays_until_released) {
  Script s;
  s.imu_until(0, 20 * kMs);
  s.frame(0);
  DoorItem item;
  ASSERT_EQ(s.door.next(item), Status::kOk);
  ASSERT_EQ(s.door.next(item), Status::kOk);
  ASSERT_TRUE(item.is_frame);
  EXPECT_EQ(s.released, 0);
  s.door.release();
  EXPECT_EQ(s.released, 1);
}

}  // namespace
}  // namespace pirvs
