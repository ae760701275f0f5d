#include "modules/app/intake.h"

#include <gtest/gtest.h>

namespace pirvs {
namespace {

constexpr TimeNs kMs = 1'000'000;

// Each look at a driver takes a microsecond; samples come every 5 ms, ticks every 10.
struct Machine {
  TimeNs now = 0, next_sample = 0, next_tick = 0;
  Status camera = Status::kEmpty, imu = Status::kOk;  // what they answer, kOk: when it is time
};
Machine machine;

Status camera_poll(StereoFrame&) {
  machine.now += 1000;
  return machine.camera;
}

Status imu_poll(ImuSample& out) {
  machine.now += 1000;
  if (machine.imu != Status::kOk) return machine.imu;
  if (machine.now < machine.next_sample) return Status::kEmpty;
  out.t = machine.next_sample;
  out.f_B = Vec3(0, 0, 9.81 + 1e-12 * double(out.t));  // no two alike: it is not stuck
  machine.next_sample += 5 * kMs;
  return Status::kOk;
}

Status tick_poll(TimeNs& out) {
  machine.now += 1000;
  if (machine.now < machine.next_tick) return Status::kEmpty;
  out = machine.next_tick;
  machine.next_tick += 10 * kMs;
  return Status::kOk;
}

class IntakeTest : public testing::Test {
 protected:
  void run(Status camera, Status imu) {
    machine = Machine{};
    machine.camera = camera;
    machine.imu = imu;
    for (int& count : count_) count = 0;
    door_.configure(Calibration{}, DoorParams{});
    intake_.configure(&door_, {this, count}, {}, {camera_poll, imu_poll, tick_poll});
    const TimeNs end = 3000 * kMs;
    for (DoorItem item; machine.now < end;) {
      const bool came = intake_.poll();
      if (!came) machine.now += 100'000;
      while (door_.next(item) == Status::kOk) {
      }
    }
  }
  static void count(void* test, const Arrival& arrival) {
    ++static_cast<IntakeTest*>(test)->count_[static_cast<int>(arrival.kind)];
  }
  int counted(ArrivalKind kind) const { return count_[static_cast<int>(kind)]; }

  Door door_;
  Intake intake_;
  int count_[static_cast<int>(ArrivalKind::kCount)] = {};
};

TEST_F(IntakeTest, ACameraThatAnswersWithFaultsAloneHoldsNobodyUp) {
  run(Status::kBusFault, Status::kOk);
  EXPECT_NEAR(counted(ArrivalKind::kImu), 600, 2);
  EXPECT_NEAR(counted(ArrivalKind::kTick), 300, 2);
  EXPECT_TRUE(door_.is_lost(Sensor::kCamera));
  EXPECT_FALSE(door_.is_lost(Sensor::kImu));
}

TEST_F(IntakeTest, TimePassesWhereBothSensorsAnswerWithFaultsAlone) {
  run(Status::kTimeout, Status::kBusFault);
  EXPECT_NEAR(counted(ArrivalKind::kTick), 300, 2);
  EXPECT_TRUE(door_.is_lost(Sensor::kCamera));
  EXPECT_TRUE(door_.is_lost(Sensor::kImu));
}

}  // namespace
}  // namespace pirvs
