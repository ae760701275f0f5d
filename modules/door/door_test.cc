// Long file: one script of arrivals, and a test for each kind of fault in it.
#include "modules/door/door.h"

#include <gtest/gtest.h>

#include <deque>
#include <limits>
#include <vector>

namespace pirvs {
namespace {

constexpr TimeNs kMs = 1'000'000;
constexpr int kSize = 16;

// A recording made of lists: the door gets what it has room for, so frames wait for samples and
// samples for frames.
struct Script {
  explicit Script(TimeNs offset = 0) {
    Calibration calibration;
    calibration.camera_time_offset_ns = offset;
    for (Camera& camera : calibration.camera) camera.width = camera.height = kSize;
    DoorListener listener;
    listener.context = this;
    listener.release = [](void* c, const StereoFrame&) { ++static_cast<Script*>(c)->released; };
    listener.fresh = [](void* c, const ImuSample& sample, bool) {
      static_cast<Script*>(c)->fresh.push_back(sample);
    };
    door.configure(calibration, DoorParams{}, listener);
  }
  // Rates and forces that are linear in time, so that interpolation is exact.
  void imu(TimeNs t) {
    const double s = to_seconds(t);
    samples.push_back({t, Vec3(s, 2 * s, -s), Vec3(10 * s, 1, 9.81)});
  }
  void imu_until(TimeNs begin, TimeNs end) {
    for (TimeNs t = begin; t <= end; t += 5 * kMs) imu(t);
  }
  // Both cameras show what no frame before has shown.
  StereoFrame& frame(TimeNs t, uint8_t present = 3) {
    StereoFrame f;
    f.t = t;
    f.present = present;
    for (ImageView& image : f.image) image = texture(int(pixels.size()));
    frames.push_back(f);
    return frames.back();
  }
  ImageView texture(int seed) {
    pixels.emplace_back(size_t{kSize} * kSize);
    for (size_t i = 0; i < pixels.back().size(); ++i) {
      pixels.back()[i] = uint8_t(i * 7 + size_t(seed) * 31);
    }
    return {pixels.back().data(), kSize, kSize, kSize};
  }
  // False: nothing is left that the door has room for.
  bool feed() {
    if (door.samples_waiting() == 0 && imu_at <= samples.size()) {
      const bool end = imu_at == samples.size();
      door.push(end ? arrival_of(ArrivalKind::kEnd, Sensor::kImu) : arrival_of(samples[imu_at]));
      ++imu_at;
      return true;
    }
    if (!door.wants_frame() || frame_at > frames.size()) return false;
    const bool end = frame_at == frames.size();
    door.push(end ? arrival_of(ArrivalKind::kEnd, Sensor::kCamera) : arrival_of(frames[frame_at]));
    ++frame_at;
    return true;
  }
  Status next(DoorItem& item) {
    for (;;) {
      while (feed()) {
      }
      const Status status = door.next(item);
      if (status != Status::kEmpty || !feed()) return status;
    }
  }

  // Everything that the door hands out until the end of the streams.
  std::vector<DoorItem> all() {
    std::vector<DoorItem> items;
    for (int guard = 0; guard < 10'000; ++guard) {
      DoorItem item;
      const Status status = next(item);
      if (status == Status::kStale) return items;
      EXPECT_EQ(status, Status::kOk);
      if (status != Status::kOk) return items;
      items.push_back(item);
      if (item.is_frame()) door.release();
    }
    ADD_FAILURE() << "the door never ends";
    return items;
  }
  uint32_t lost(DoorLoss loss) const { return door.losses()[loss]; }
  uint32_t lost() const {
    uint32_t sum = 0;
    for (int i = 0; i < static_cast<int>(DoorLoss::kCount); ++i) sum += door.losses().count[i];
    return sum;
  }

  std::vector<ImuSample> samples;
  std::deque<StereoFrame> frames;  // frame() hands out references
  std::deque<std::vector<uint8_t>> pixels;
  size_t imu_at = 0, frame_at = 0;
  int released = 0;
  std::vector<ImuSample> fresh;
  Door door;
};

TimeNs time_of(const DoorItem& item) { return item.is_frame() ? item.frame.t : item.imu.t; }

std::vector<TimeNs> frame_times(const std::vector<DoorItem>& items) {
  std::vector<TimeNs> out;
  for (const DoorItem& item : items) {
    if (item.is_frame()) out.push_back(item.frame.t);
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
    if (items[i].is_frame()) {
      ASSERT_FALSE(items[i - 1].is_frame());
      EXPECT_EQ(time_of(items[i]), items[i - 1].imu.t);
    } else if (!items[i - 1].is_frame()) {
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
    if (item.is_frame()) continue;
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
  EXPECT_FALSE(items[0].is_frame());
  EXPECT_TRUE(items[1].is_frame()) << "the first sample lies at the first frame";
}

TEST(door, camera_stamps_move_to_the_clock_of_the_imu) {
  Script s(-7 * kMs);
  s.imu_until(0, 50 * kMs);
  s.frame(27 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(frame_times(items), std::vector<TimeNs>{20 * kMs});
}

TEST(door, hands_out_samples_without_the_errors_that_are_known_of_the_imu) {
  Calibration calibration;
  ImuIntrinsics& known = calibration.imu_intrinsics;
  known.gyro << 1.01, 0.02, 0, 0, 0.99, 0, 0.01, 0, 1;
  known.accel << 0.98, 0, 0, 0.01, 1, 0, 0, 0.02, 1.03;
  known.b_g = Vec3(0.1, -0.2, 0.3);
  known.b_a = Vec3(-0.5, 0.4, 0.2);
  const Vec3 w_B(0.3, -0.5, 1.2), f_B(1, -2, 9.5);
  Door door;
  door.configure(calibration, DoorParams{});
  ImuSample raw{kMs, known.gyro * w_B + known.b_g, known.accel * f_B + known.b_a};
  door.push(arrival_of(raw));
  door.push(arrival_of(ArrivalKind::kEnd, Sensor::kCamera));
  DoorItem item;
  ASSERT_EQ(door.next(item), Status::kOk);
  EXPECT_LT((item.imu.w_B - w_B).norm(), 1e-12);
  EXPECT_LT((item.imu.f_B - f_B).norm(), 1e-12);
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

TEST(door, a_frame_passes_with_one_image_or_none) {
  Script s;
  s.imu_until(0, 100 * kMs);
  s.frame(20 * kMs, 1);
  s.frame(40 * kMs, 0);
  s.frame(60 * kMs, 2);
  s.frame(80 * kMs, 3);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kCameraMissing), 3u);
  EXPECT_EQ(frame_times(items), (std::vector<TimeNs>{20 * kMs, 40 * kMs, 60 * kMs, 80 * kMs}))
      << "blind, too: whoever judges health must see it";
}

TEST(door, the_end_is_stale_and_stays_so) {
  Script s;
  s.imu_until(0, 20 * kMs);
  s.frame(10 * kMs);
  EXPECT_EQ(s.all().size(), 6u) << "samples after the last frame come out as well";
  DoorItem item;
  EXPECT_EQ(s.next(item), Status::kStale);
  EXPECT_EQ(s.next(item), Status::kStale);
}

TEST(door, nothing_at_all_ends_at_once) {
  Script s;
  DoorItem item;
  EXPECT_EQ(s.next(item), Status::kStale);
}

TEST(door, a_frame_stays_until_released) {
  Script s;
  s.imu_until(0, 20 * kMs);
  s.frame(0);
  DoorItem item;
  ASSERT_EQ(s.next(item), Status::kOk);
  ASSERT_EQ(s.next(item), Status::kOk);
  ASSERT_TRUE(item.is_frame());
  EXPECT_EQ(s.released, 0);
  s.door.release();
  EXPECT_EQ(s.released, 1);
}

std::vector<int> presents(const std::vector<DoorItem>& items) {
  std::vector<int> out;
  for (const DoorItem& item : items) {
    if (item.is_frame()) out.push_back(item.frame.images.present);
  }
  return out;
}

TEST(door, an_image_that_is_late_is_left_out) {
  Script s;
  s.imu_until(0, 100 * kMs);
  s.frame(20 * kMs).late[1] = 50 * kMs;
  s.frame(40 * kMs).late[0] = -2 * kMs;
  s.frame(60 * kMs).late[1] = kMs / 2;
  EXPECT_EQ(presents(s.all()), (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(s.lost(DoorLoss::kCameraLate), 2u);
}

TEST(door, frozen_images_are_left_out_flat_ones_are_not) {
  Script s;
  s.imu_until(0, 200 * kMs);
  s.frame(20 * kMs);
  s.frame(40 * kMs).image[1] = s.frames[0].image[1];
  s.frame(60 * kMs);
  s.frames[2].image[0] = s.frames[1].image[0];
  s.frames[2].image[1] = s.frames[0].image[1];
  s.frame(80 * kMs);
  std::vector<uint8_t> black(size_t{kSize} * kSize, 0);
  for (TimeNs t = 100 * kMs; t < 150 * kMs; t += 20 * kMs) {
    for (ImageView& image : s.frame(t).image) image.data = black.data();
  }
  EXPECT_EQ(presents(s.all()), (std::vector<int>{3, 1, 0, 3, 3, 3, 3}));
  EXPECT_EQ(s.lost(DoorLoss::kCameraFrozen), 3u);
}

TEST(door, images_of_another_size_are_left_out) {
  Script s;
  s.imu_until(0, 100 * kMs);
  s.frame(20 * kMs).image[0].width = 8;
  s.frame(40 * kMs).image[1] = ImageView{};
  EXPECT_EQ(presents(s.all()), (std::vector<int>{2, 1}));
  EXPECT_EQ(s.lost(DoorLoss::kCameraWrongSize), 2u);
}

// Bias and motion stay, only the sample that sticks out goes.
TEST(door, a_spike_is_dropped_a_step_and_a_shock_are_not) {
  Script spike;
  spike.imu_until(0, 100 * kMs);
  spike.samples[5].w_B.x() += 30;
  spike.samples[6].f_B.z() -= 150;
  spike.samples[12].f_B.x() += 30;
  spike.frame(90 * kMs);
  for (const DoorItem& item : spike.all()) EXPECT_LT(item.imu.w_B.norm(), 1);
  EXPECT_EQ(spike.lost(DoorLoss::kImuSpike), 3u);
  Script step;
  step.imu_until(0, 100 * kMs);
  for (size_t i = 8; i < step.samples.size(); ++i) step.samples[i].w_B.y() += 5;
  for (size_t i = 3; i < 5; ++i) step.samples[i].f_B.y() += 60;  // two samples: felt
  step.frame(90 * kMs);
  EXPECT_EQ(step.all().size(), 21u + 1u);
  EXPECT_EQ(step.lost(), 0u);
}

// A shaken IMU's samples jump all the time; a spike stands out of them all the same.
TEST(door, vibration_is_not_spikes) {
  Script s;
  s.imu_until(0, 2000 * kMs);
  for (size_t i = 0; i < s.samples.size(); ++i) {
    const double t_s = 0.005 * static_cast<double>(i);
    for (int axis = 0; axis < 3; ++axis) {
      const double tone = std::sin(2 * 3.14159265 * (87.3 + 3.1 * axis) * t_s + axis) +
                          0.5 * std::sin(2 * 3.14159265 * (61.7 - 2 * axis) * t_s);
      s.samples[i].f_B[axis] += 30 * tone;
      s.samples[i].w_B[axis] += 2 * tone;
    }
  }
  s.samples[300].f_B.x() += 250;
  s.frame(1990 * kMs);
  (void)s.all();
  EXPECT_GE(s.lost(DoorLoss::kImuSpike), 1u);
  EXPECT_LE(s.lost(DoorLoss::kImuSpike), 20u) << "as the motors start: of 400";
}

TEST(door, saturated_samples_are_bridged) {
  Script s;
  s.imu_until(0, 300 * kMs);
  for (size_t i = 20; i < 40; ++i) s.samples[i].w_B = Vec3(34.9, -34.9, 34.9);
  s.samples[50].f_B.z() = -156.5;
  s.frame(150 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kImuSaturated), 21u);
  EXPECT_EQ(s.lost(DoorLoss::kImuGap), 1u);
  for (const DoorItem& item : items) {
    if (item.is_frame()) continue;
    const double t = to_seconds(item.imu.t);
    EXPECT_LT((item.imu.w_B - Vec3(t, 2 * t, -t)).norm(), 1e-12);
  }
}

TEST(door, a_stuck_imu_is_bridged) {
  Script s;
  s.imu_until(0, 300 * kMs);
  for (size_t i = 20; i < 50; ++i) {
    s.samples[i].w_B = s.samples[19].w_B;
    s.samples[i].f_B = s.samples[19].f_B;
  }
  s.frame(290 * kMs);
  EXPECT_EQ(s.all().size(), 61u + 1u - 22u);
  EXPECT_EQ(s.lost(DoorLoss::kImuStuck), 31u - 9u) << "the tenth equal one is the first to go";
}

size_t breaks(const std::vector<DoorItem>& items) {
  size_t count = 0;
  for (const DoorItem& item : items) count += item.broken;
  return count;
}

TEST(door, a_long_gap_breaks_the_stream) {
  Script s;
  s.imu_until(0, 100 * kMs);
  s.imu_until(1'300 * kMs, 1'600 * kMs);
  s.frame(100 * kMs);
  s.frame(400 * kMs);
  s.frame(1'550 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(breaks(items), 1u);
  EXPECT_EQ(s.lost(DoorLoss::kStreamBroken), 1u);
  EXPECT_EQ(s.lost(DoorLoss::kFrameBeforeImu), 1u) << "no sample can be made for it";
  EXPECT_EQ(frame_times(items), (std::vector<TimeNs>{100 * kMs, 1'550 * kMs}));
}

TEST(door, one_stamp_from_the_future_is_dropped) {
  Script s;
  s.imu_until(0, 300 * kMs);
  s.samples[10].t += 3'600'000 * kMs;
  s.frame(200 * kMs);
  const std::vector<DoorItem> items = s.all();
  EXPECT_EQ(s.lost(DoorLoss::kImuStampAhead), 1u);
  EXPECT_EQ(breaks(items), 0u);
  EXPECT_EQ(items.size(), 60u + 1u);
}

// Both clocks jump, forth and back, as when somebody sets the time of day.
TEST(door, a_clock_that_jumps_breaks_the_stream_and_goes_on) {
  for (const TimeNs jump : {5'000 * kMs, -5'000 * kMs}) {
    Script s;
    const TimeNs begin = 5'000 * kMs;
    s.imu_until(begin, begin + 1'000 * kMs);
    s.imu_until(begin + 1'005 * kMs + jump, begin + 3'000 * kMs + jump);
    for (TimeNs t = 50 * kMs; t < 3'000 * kMs; t += 50 * kMs) {
      s.frame(begin + t + (t > 1'000 * kMs ? jump : 0));
    }
    const std::vector<DoorItem> items = s.all();
    EXPECT_EQ(breaks(items), 1u) << jump;
    EXPECT_EQ(s.lost(DoorLoss::kImuClockBack), jump < 0 ? 1u : 0u);
    const size_t frames = frame_times(items).size();
    EXPECT_GE(frames, jump < 0 ? 48u : 59u) << "back, it takes half a second to be believed";
    EXPECT_EQ(frame_times(items).back(), begin + 2'950 * kMs + jump);
  }
}

TEST(door, says_of_samples_on_a_line_how_long_it_is) {
  Script s;
  s.imu_until(0, 100 * kMs);
  s.imu_until(300 * kMs, 400 * kMs);
  s.frame(98 * kMs);
  s.frame(200 * kMs);
  s.frame(302 * kMs);
  for (const DoorItem& item : s.all()) {
    if (item.is_frame()) continue;
    const bool bridged = item.imu.t > 100 * kMs && item.imu.t <= 300 * kMs;
    EXPECT_FLOAT_EQ(item.imu.gap_s, bridged ? 0.2f : 0.0f) << item.imu.t;
  }
  EXPECT_EQ(s.lost(DoorLoss::kImuGap), 1u);
}

TEST(door, stamps_beyond_any_time_are_dropped) {
  for (const TimeNs stamp : {std::numeric_limits<TimeNs>::max(), kStampMax + 1,
                             std::numeric_limits<TimeNs>::min(), -kStampMax - 1}) {
    Script s;
    s.imu_until(0, 100 * kMs);
    s.samples[5].t = stamp;
    s.frame(20 * kMs);
    s.frame(stamp);
    s.frame(60 * kMs);
    EXPECT_EQ(frame_times(s.all()), (std::vector<TimeNs>{20 * kMs, 60 * kMs}));
    EXPECT_EQ(s.lost(DoorLoss::kImuStampImpossible), 1u);
    EXPECT_EQ(s.lost(DoorLoss::kFrameStampImpossible), 1u);
    EXPECT_EQ(s.lost(), 2u);
  }
}

TEST(door, stamps_may_be_as_far_apart_as_stamps_can) {
  Script s;
  s.imu_until(0, 100 * kMs);
  s.frame(20 * kMs);
  s.frame(-kStampMax);
  s.frame(kStampMax);
  EXPECT_EQ(frame_times(s.all()), std::vector<TimeNs>{20 * kMs});
  EXPECT_EQ(s.lost(DoorLoss::kFrameBackwards), 1u);
  EXPECT_EQ(s.lost(DoorLoss::kFrameWithoutImu), 1u);
}

// Frames every 50 ms for a second, from the tenth on `jump` later; likewise the IMU's samples.
void run_with_jumps(Script& s, TimeNs cameras, TimeNs imu) {
  const TimeNs begin = 10'000 * kMs;
  s.imu_until(begin, begin + 500 * kMs);
  s.imu_until(begin + 505 * kMs + imu, begin + 3'000 * kMs + imu);
  for (TimeNs t = 0; t < 2'000 * kMs; t += 50 * kMs) {
    s.frame(begin + t + (t > 500 * kMs ? cameras : 0));
  }
}

TEST(door, a_step_of_one_sensors_stamps_is_doubted_until_somebody_knows) {
  struct Case {
    TimeNs cameras, imu, shift;
  };
  for (const Case& c : {Case{400, 0, -400}, Case{-400, 0, 400}, Case{0, 400, 400},
                        Case{0, -400, -400}, Case{0, -700, -700}}) {
    Script s;
    run_with_jumps(s, c.cameras * kMs, c.imu * kMs);
    (void)s.all();
    EXPECT_EQ(s.door.watch().shift(), c.shift * kMs) << c.cameras << ' ' << c.imu;
    EXPECT_EQ(s.door.watch().is_imus(), c.imu != 0);
    EXPECT_EQ(s.lost(DoorLoss::kCameraGap), c.cameras > 0 ? 1u : 0u);
    s.door.watch().reject_step();
    EXPECT_EQ(s.door.watch().shift(), 0);
  }
}

TEST(door, both_clocks_set_together_or_a_few_frames_lost_leave_no_doubt) {
  for (const TimeNs jump : {0, 100, 400, -400, 5'000, -5'000}) {
    Script s;
    run_with_jumps(s, jump * kMs, jump * kMs);
    s.frames.erase(s.frames.begin() + 5, s.frames.begin() + 7);
    (void)s.all();
    EXPECT_EQ(s.door.watch().shift(), 0) << jump;
  }
}

TEST(door, a_clock_that_was_set_is_taken_into_account_from_then_on) {
  Script s;
  run_with_jumps(s, 400 * kMs, 0);
  std::vector<TimeNs> frames;
  DoorItem item;
  while (s.next(item) == Status::kOk) {
    if (!item.is_frame()) continue;
    frames.push_back(item.frame.t);
    if (frames.size() == 15) s.door.clock_was_set();  // 4 frames after the step
    s.door.release();
  }
  EXPECT_EQ(s.lost(DoorLoss::kCameraClockSet), 1u);
  EXPECT_EQ(s.door.watch().shift(), 0);
  EXPECT_EQ(frames[14], 11'100 * kMs) << "as stamped";
  EXPECT_EQ(frames[15], 11'100 * kMs) << "the first one that is not too late for the samples";
  EXPECT_EQ(frames.back(), 11'950 * kMs);
  EXPECT_EQ(s.lost(DoorLoss::kFrameBeforeImu), 7u);
}

TEST(door, good_samples_are_told_at_once) {
  Script s;
  s.imu_until(0, 50 * kMs);
  s.samples[3].w_B.x() = std::numeric_limits<double>::quiet_NaN();
  for (const ImuSample& sample : s.samples) s.door.push(arrival_of(sample));
  ASSERT_EQ(s.fresh.size(), 10u);
  EXPECT_EQ(s.fresh.back().t, 50 * kMs);
  DoorItem item;
  EXPECT_EQ(s.door.next(item), Status::kEmpty) << "they wait for a frame";
}

TEST(door, a_full_queue_of_samples_waits_no_longer_and_counts_what_it_cannot_take) {
  Script s;
  for (TimeNs t = 0; s.door.wants_imu(); t += kMs) {
    s.imu(t);
    s.door.push(arrival_of(s.samples.back()));
  }
  s.door.push(arrival_of(ImuSample{600 * kMs, Vec3(1, 1, 1), Vec3(0, 0, 9.81)}));
  EXPECT_EQ(s.lost(DoorLoss::kImuQueueFull), 1u);
  DoorItem item;
  EXPECT_EQ(s.door.next(item), Status::kOk);
  EXPECT_EQ(item.imu.t, 0);
  EXPECT_EQ(s.door.next(item), Status::kEmpty);
}

}  // namespace
}  // namespace pirvs
