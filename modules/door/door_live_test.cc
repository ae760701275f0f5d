// The door as a live device feeds it: everything at its time, silences and faults by ticks.
#include <gtest/gtest.h>

#include <vector>

#include "modules/door/door.h"

namespace pirvs {
namespace {

constexpr TimeNs kMs = 1'000'000;

TimeNs time_of(const DoorItem& item) { return item.is_frame() ? item.frame.t : item.imu.t; }

// Live: everything comes at its time, with a tick every 10 ms.
struct Live {
  explicit Live(TimeNs cameras_jump = 0) : jump(cameras_jump) {
    DoorParams params;
    params.break_s = 0.1f;
    params.bridge_s = 0.2f;
    door.configure(Calibration{}, params);
  }
  void push(const Arrival& arrival) {
    door.push(arrival);
    DoorItem item;
    while (door.next(item) == Status::kOk) {
      items.push_back(item);
      if (item.is_frame()) door.release();
    }
  }
  static ImuSample sample(TimeNs t) {  // no two alike: it is not stuck
    return {t, Vec3(1e-9 * double(t), 0, 0), Vec3(0, 0, 9.81)};
  }
  // Samples every 5 ms until imu_end, frames every 10 ms until cameras_end, `jump` ahead from
  // 100 ms on; until `end`.
  void run(TimeNs imu_end, TimeNs cameras_end, TimeNs end) {
    for (; now < end; now += 5 * kMs) {
      if (now <= imu_end) push(arrival_of(sample(now)));
      if (now % (10 * kMs) != 0) continue;
      if (now < cameras_end && door.wants_frame()) {
        StereoFrame frame;
        frame.t = now + (now < 100 * kMs ? 0 : jump);
        ++frames;
        push(arrival_of(frame));
      }
      push(tick_at(kMachine + now));
    }
  }
  int told(DoorLoss what) const {
    int count = 0;
    for (const DoorItem& item : items) {
      count += item.kind == DoorItemKind::kEvent && item.event == what;
    }
    return count;
  }
  size_t samples_out() const {
    size_t count = 0;
    for (const DoorItem& item : items) count += item.is_imu();
    return count;
  }
  uint32_t lost(DoorLoss loss) const { return door.losses()[loss]; }

  static constexpr TimeNs kMachine = 77'000'000 * kMs;  // its clock is another one
  TimeNs now = 0, jump = 0;
  int frames = 0;
  std::vector<DoorItem> items;
  Door door;
};

TEST(door_live, silent_cameras_hold_up_the_imu_for_a_moment_only) {
  Live live;
  live.run(2'000 * kMs, 0, 160 * kMs);
  EXPECT_EQ(live.samples_out(), 0u) << "a frame may still come";
  EXPECT_EQ(live.lost(DoorLoss::kCameraSilent), 0u);
  live.run(2'000 * kMs, 0, 165 * kMs);
  EXPECT_EQ(live.samples_out(), 33u);
  live.run(2'000 * kMs, 0, 300 * kMs);
  EXPECT_EQ(live.samples_out(), 60u) << "the rest waits no longer";
  EXPECT_EQ(live.lost(DoorLoss::kCameraSilent), 1u);
}

TEST(door_live, frames_that_come_after_a_silence_are_waited_for_again) {
  Live live;
  live.run(2'000 * kMs, 50 * kMs, 400 * kMs);
  live.run(2'000 * kMs, 800 * kMs, 500 * kMs);
  const size_t out = live.samples_out();
  EXPECT_EQ(live.frames, 15);
  live.run(2'000 * kMs, 0, 600 * kMs);
  EXPECT_EQ(live.samples_out(), out);
  EXPECT_EQ(live.lost(DoorLoss::kCameraSilent), 1u);
}

TEST(door_live, live_frames_from_the_future_say_that_the_cameras_clock_was_set) {
  Live live(390 * kMs);
  live.run(100 * kMs, 10'000 * kMs, 200 * kMs);
  EXPECT_EQ(live.lost(DoorLoss::kCameraClockSet), 1u);
  EXPECT_EQ(live.lost(DoorLoss::kFrameAhead), 2u) << "as many may be an accident";
}

TEST(door_live, live_frames_from_the_future_by_too_small_a_step_are_dropped_all) {
  Live live(110 * kMs);
  live.run(100 * kMs, 10'000 * kMs, 200 * kMs);
  EXPECT_GE(live.lost(DoorLoss::kFrameAhead), 4u);
  EXPECT_EQ(live.lost(DoorLoss::kCameraClockSet), 0u) << "no stamp has stepped by clock_step_s";
}

TEST(door_live, a_silent_imu_is_told_once) {
  Live live;
  live.run(100 * kMs, 10'000 * kMs, 300 * kMs);
  EXPECT_EQ(live.told(DoorLoss::kImuSilent), 0) << "0.1 s of samples, bridge_s of silence";
  live.run(100 * kMs, 10'000 * kMs, 350 * kMs);
  EXPECT_EQ(live.told(DoorLoss::kImuSilent), 1);
  live.run(100 * kMs, 10'000 * kMs, 2'000 * kMs);
  EXPECT_EQ(live.told(DoorLoss::kImuSilent), 1);
  EXPECT_EQ(live.lost(DoorLoss::kImuSilent), 1u);
  EXPECT_EQ(live.frames, 12) << "a frame waits for its sample";
}

TEST(door_live, faults_of_a_driver_are_counted_by_sensor_and_name_and_change_nothing) {
  Live good, faulty;
  good.run(2'000 * kMs, 2'000 * kMs, 1'000 * kMs);
  for (TimeNs end = 10 * kMs; end <= 1'000 * kMs; end += 10 * kMs) {
    faulty.run(2'000 * kMs, 2'000 * kMs, end);
    for (const Sensor sensor : {Sensor::kImu, Sensor::kCamera}) {
      for (int i = 0; i < 20; ++i) {
        faulty.push(arrival_of(ArrivalKind::kFault, sensor, Status::kBusFault));
      }
      for (int i = 0; i < 2; ++i) {
        faulty.push(arrival_of(ArrivalKind::kFault, sensor, Status::kTimeout));
      }
      faulty.push(arrival_of(ArrivalKind::kFault, sensor, Status::kBadData));
    }
  }
  EXPECT_EQ(faulty.lost(DoorLoss::kImuBusFault), 2000u);
  EXPECT_EQ(faulty.lost(DoorLoss::kCameraBusFault), 2000u);
  EXPECT_EQ(faulty.lost(DoorLoss::kImuTimeout), 200u);
  EXPECT_EQ(faulty.lost(DoorLoss::kCameraTimeout), 200u);
  EXPECT_EQ(faulty.lost(DoorLoss::kImuBadData), 100u);
  EXPECT_EQ(faulty.lost(DoorLoss::kCameraBadData), 100u);
  EXPECT_EQ(faulty.told(DoorLoss::kImuBusFault), 1) << "at most once a second";
  EXPECT_EQ(faulty.told(DoorLoss::kCameraBusFault), 1);
  EXPECT_EQ(faulty.told(DoorLoss::kImuLostDevice), 0);
  std::vector<TimeNs> with, without;
  for (const DoorItem& item : good.items) without.push_back(time_of(item));
  for (const DoorItem& item : faulty.items) {
    if (item.kind != DoorItemKind::kEvent) with.push_back(time_of(item));
  }
  EXPECT_EQ(with, without);
}

TEST(door_live, frames_that_a_driver_lost_are_counted_and_told_at_most_once_a_second) {
  Live live;
  for (TimeNs end = 50 * kMs; end <= 1'900 * kMs; end += 50 * kMs) {
    live.run(5'000 * kMs, 0, end);
    StereoFrame frame;
    frame.t = live.now - 5 * kMs;
    frame.lost_before = 2;
    live.push(arrival_of(frame));
    live.push(arrival_of(Live::sample(live.now), true));
    live.now += 5 * kMs;
    live.push(arrival_of(bsp::GpioEdge{live.now, {1, 2}, true}, true));
  }
  EXPECT_EQ(live.lost(DoorLoss::kFramesLost), 2 * 38u);
  EXPECT_EQ(live.lost(DoorLoss::kImuLost), 38u);
  EXPECT_EQ(live.lost(DoorLoss::kEdgesLost), 38u);
  EXPECT_EQ(live.told(DoorLoss::kFramesLost), 2);
}

TEST(door_live, a_sensor_that_gives_faults_alone_is_lost_until_it_gives_an_item) {
  Live live;
  live.run(100 * kMs, 2'000 * kMs, 200 * kMs);
  for (int i = 0; i < 80; ++i) {
    live.push(arrival_of(ArrivalKind::kFault, Sensor::kImu, Status::kBusFault));
    live.push(tick_at(Live::kMachine + live.now));
    live.now += 10 * kMs;
    EXPECT_EQ(live.door.is_lost(Sensor::kImu), i >= 50) << i;
  }
  live.run(5'000 * kMs, 5'000 * kMs, 2'000 * kMs);
  EXPECT_FALSE(live.door.is_lost(Sensor::kImu));
  EXPECT_EQ(live.told(DoorLoss::kImuLostDevice), 1);
  EXPECT_EQ(live.told(DoorLoss::kImuBack), 1);
  EXPECT_EQ(live.lost(DoorLoss::kImuBack), 1u);
  EXPECT_EQ(time_of(live.items.back()), 1'990 * kMs);
}

TEST(door_live, what_a_driver_says_is_lost_is_lost) {
  Live live;
  live.push(arrival_of(ArrivalKind::kLost, Sensor::kCamera));
  live.push(arrival_of(ArrivalKind::kLost, Sensor::kCamera));
  EXPECT_TRUE(live.door.is_lost(Sensor::kCamera));
  live.push(arrival_of(ArrivalKind::kBack, Sensor::kCamera));
  EXPECT_FALSE(live.door.is_lost(Sensor::kCamera));
  EXPECT_EQ(live.lost(DoorLoss::kCameraLostDevice), 1u);
  EXPECT_EQ(live.lost(DoorLoss::kCameraBack), 1u);
}

// What samples that are pushed ahead while a frame is being tracked may not change.
TEST(door_live, samples_pushed_at_once_give_the_items_of_samples_pushed_one_by_one) {
  std::vector<Arrival> arrivals;
  for (TimeNs t = 0; t < 3'000 * kMs; t += 5 * kMs) {
    const TimeNs imu_jump = t > 1'000 * kMs ? 400 * kMs : 0;
    const bool silent = t > 1'500 * kMs && t < 2'000 * kMs;
    ImuSample sample = Live::sample(t + imu_jump);
    if (t % (400 * kMs) == 0) sample.w_B.x() += 30;
    arrivals.push_back(arrival_of(sample));
    if (t % (50 * kMs) == 25 * kMs && !silent) {
      StereoFrame frame;
      frame.t = t - 22 * kMs;
      arrivals.push_back(arrival_of(frame));
    }
    if (t % (10 * kMs) == 0 && (t < 200 * kMs || silent)) arrivals.push_back(tick_at(t));
  }
  std::vector<DoorItem> out[2];
  for (const bool at_once : {false, true}) {
    Live live;
    for (size_t i = 0; i < arrivals.size(); ++i) {
      if (arrivals[i].kind == ArrivalKind::kFrame && !live.door.wants_frame()) continue;
      // Only samples may be pushed before all is handed out.
      const bool next_is_imu = i + 1 < arrivals.size() && arrivals[i + 1].kind == ArrivalKind::kImu;
      if (at_once && arrivals[i].kind == ArrivalKind::kImu && next_is_imu) {
        live.door.push(arrivals[i]);
      } else {
        live.push(arrivals[i]);
      }
    }
    out[at_once] = live.items;
  }
  ASSERT_EQ(out[0].size(), out[1].size());
  EXPECT_GT(out[0].size(), 500u);
  for (size_t i = 0; i < out[0].size(); ++i) {
    EXPECT_EQ(out[0][i].kind, out[1][i].kind) << i;
    EXPECT_EQ(time_of(out[0][i]), time_of(out[1][i])) << i;
  }
}

TEST(door_live, fixes_wheels_and_edges_pass_in_order_of_sensor_time_commands_at_once) {
  Live live;
  const auto fix = [&](TimeNs t) {
    Arrival out;
    out.kind = ArrivalKind::kGnss;
    out.gnss.t = t;
    live.push(out);
  };
  const auto edge = [&](TimeNs t) {
    Arrival out;
    out.kind = ArrivalKind::kEdge;
    out.edge.t = t;
    live.push(out);
  };
  live.run(2'000 * kMs, 2'000 * kMs, 100 * kMs);
  fix(152 * kMs);
  edge(131 * kMs);
  fix(40 * kMs);  // late
  fix(kStampMax + 1);
  Arrival wheel;
  wheel.kind = ArrivalKind::kWheel;
  wheel.wheel.t = 140 * kMs;
  live.push(wheel);
  Command command;
  command.value = 7;
  live.push(arrival_of(command));
  live.run(2'000 * kMs, 2'000 * kMs, 200 * kMs);
  std::vector<DoorItemKind> kinds;
  TimeNs t = 0;
  for (const DoorItem& item : live.items) {
    if (item.is_imu() || item.is_frame()) {
      t = time_of(item);
      continue;
    }
    kinds.push_back(item.kind);
    if (item.kind == DoorItemKind::kEdge) {
      EXPECT_EQ(t, 130 * kMs);
    }
    if (item.kind == DoorItemKind::kWheel) {
      EXPECT_EQ(t, 135 * kMs);
    }
  }
  EXPECT_EQ(kinds, (std::vector<DoorItemKind>{DoorItemKind::kGnss, DoorItemKind::kCommand,
                                              DoorItemKind::kEdge, DoorItemKind::kWheel,
                                              DoorItemKind::kGnss}));
  EXPECT_EQ(live.lost(DoorLoss::kAsideStampImpossible), 1u);
}

Arrival wheel_at(TimeNs t) { return arrival_of(WheelSample{t, {1, 2}, WheelKind::kTicks}); }

// Two wheels at 50 Hz that turn for a second before the IMU begins.
TEST(door_live, wheels_before_the_imu_are_dropped_and_take_no_room_from_those_after) {
  constexpr TimeNs kBegin_ns = 1'000 * kMs, kEnd_ns = 1'200 * kMs;
  Live live;
  const auto wheels = [&](TimeNs t) {
    live.push(wheel_at(t));
    live.push(wheel_at(t + 1));
  };
  for (; live.now < kBegin_ns; live.now += 10 * kMs) {
    if (live.now % (20 * kMs) == 0) wheels(live.now);
    live.push(tick_at(Live::kMachine + live.now));
  }
  // The IMU's first samples come late, as those of a FIFO do: wheels of their time are there.
  wheels(kBegin_ns + 2 * kMs);
  wheels(kBegin_ns + 22 * kMs);
  live.push(arrival_of(Live::sample(kBegin_ns)));
  live.push(wheel_at(kBegin_ns - 10 * kMs));  // late
  live.push(wheel_at(kBegin_ns));
  live.now = kBegin_ns + 5 * kMs;
  live.run(kEnd_ns, kEnd_ns, kEnd_ns);
  std::vector<TimeNs> passed;
  for (const DoorItem& item : live.items) {
    if (item.kind == DoorItemKind::kWheel) passed.push_back(item.wheel.t);
  }
  EXPECT_EQ(passed, (std::vector<TimeNs>{kBegin_ns, kBegin_ns + 2 * kMs, kBegin_ns + 2 * kMs + 1,
                                         kBegin_ns + 22 * kMs, kBegin_ns + 22 * kMs + 1}));
  EXPECT_EQ(live.lost(DoorLoss::kAsideBeforeImu), 101u);
  EXPECT_EQ(live.lost(DoorLoss::kAsideFull), 0u);
}

TEST(door_live, wheels_without_an_imu_end_with_the_sensors) {
  Live live;
  for (int i = 0; i < 5; ++i) live.push(wheel_at(i * kMs));
  live.push(arrival_of(ArrivalKind::kEnd, Sensor::kImu));
  live.push(arrival_of(ArrivalKind::kEnd, Sensor::kCamera));
  for (const DoorItem& item : live.items) EXPECT_NE(item.kind, DoorItemKind::kWheel);
  EXPECT_EQ(live.lost(DoorLoss::kAsideBeforeImu), 5u);
}

}  // namespace
}  // namespace pirvs
