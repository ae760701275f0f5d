#include "bsp/drivers/icm20602/icm20602.h"

#include <gtest/gtest.h>

#include "bsp/api/clock.h"
#include "bsp/drivers/emulated/i2c_bus.h"
#include "bsp/drivers/icm20602/icm20602_emulator.h"

namespace pirvs::bsp {
namespace {

constexpr int kBus = 7;
constexpr uint8_t kAddress = 0x68;
constexpr TimeNs kMs = 1'000'000;

TEST(Icm20602Decode, TurnsWordsIntoUnits) {
  const uint8_t packet[14] = {0x10, 0x00, 0xf0, 0x00, 0x7f, 0xff, 0,
                              0,    0x40, 0x00, 0x80, 0x00, 0,    1};
  ImuSample sample;
  ASSERT_TRUE(icm20602_decode(packet, sample));
  EXPECT_NEAR(sample.f_B.x(), 9.80665, 1e-9);  // 4096 of 32768 for 8 g
  EXPECT_NEAR(sample.f_B.y(), -9.80665, 1e-9);
  EXPECT_NEAR(sample.f_B.z(), 8 * 9.80665, 0.01);
  EXPECT_NEAR(sample.w_B.x(), 1000.0 * M_PI / 180.0, 1e-9);
  EXPECT_NEAR(sample.w_B.y(), -2000.0 * M_PI / 180.0, 1e-9);
  EXPECT_NEAR(sample.w_B.z(), 2000.0 / 32768.0 * M_PI / 180.0, 1e-12);
}

TEST(Icm20602Decode, RefusesAnEmptyFifo) {
  uint8_t packet[14];
  for (uint8_t& byte : packet) byte = 0xff;
  ImuSample sample;
  EXPECT_FALSE(icm20602_decode(packet, sample));
}

// The chip measures every 5 ms; sample i reads i on the x axis of the accelerometer.
class Icm20602Driver : public testing::Test {
 protected:
  emulated::Icm20602Chip chip_{kAddress};
  emulated::I2cAttachment attachment_{kBus, chip_};
  Icm20602 driver_{kBus, kAddress};
  TimeNs t_ = 0;
  int next_ = 0;  // sample to be measured
  int seen_ = 0;  // sample to be polled

  void SetUp() override {
    ASSERT_EQ(driver_.set_up(), Status::kOk);
    t_ = 0;
  }

  void measure(bool edge_seen = true) {
    const int16_t f[3] = {static_cast<int16_t>(next_++), 0, 0};
    const bool pulsed = chip_.sample(f, {0, 0, 0});
    if (pulsed && edge_seen) driver_.data_ready(t_);
  }
  // Five milliseconds with a step in each quarter, the first right after the sample.
  Status run_period(bool edge_seen = true) {
    measure(edge_seen);
    Status worst = Status::kOk;
    for (int quarter = 0; quarter < 20; ++quarter) {
      t_ += kMs / 4;
      const Status status = driver_.step(t_);
      if (status != Status::kOk) worst = status;
    }
    return worst;
  }
  // The samples from seen_ to `end` come in order, each with the stamp of its own edge.
  void expect_samples(int end) {
    ImuSample sample;
    for (; seen_ < end; ++seen_) {
      ASSERT_EQ(driver_.poll(sample), Status::kOk) << seen_;
      EXPECT_NEAR(sample.f_B.x(), seen_ * 9.80665 / 4096, 1e-9);
      EXPECT_EQ(sample.t, seen_ * Icm20602::kPeriod) << seen_;
    }
    EXPECT_EQ(driver_.poll(sample), Status::kEmpty);
  }
};

TEST_F(Icm20602Driver, HandsOnEverySampleWithItsOwnStamp) {
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(run_period(), Status::kOk);
    expect_samples(i + 1);
  }
  EXPECT_EQ(driver_.counters().lost + driver_.counters().guessed, 0u);
}

TEST_F(Icm20602Driver, CatchesUpInBatches) {
  for (int i = 0; i < 20; ++i, t_ += Icm20602::kPeriod) measure();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(run_period(), Status::kOk);
  expect_samples(23);
  EXPECT_EQ(driver_.counters().lost, 0u);
}

TEST_F(Icm20602Driver, DoesNotMistakeASampleThatComesBetweenEdgeAndCount) {
  measure();
  t_ += kMs;
  EXPECT_EQ(driver_.step(t_), Status::kOk);  // asks for the count
  t_ += 4 * kMs;                             // and comes back too late: the next sample is there
  measure();
  EXPECT_EQ(driver_.step(t_), Status::kOk);
  EXPECT_EQ(driver_.step(t_), Status::kOk);
  for (int i = 0; i < 4; ++i) t_ += kMs / 4, (void)driver_.step(t_);
  t_ = 10 * kMs;
  EXPECT_EQ(run_period(), Status::kOk);
  expect_samples(3);
}

TEST_F(Icm20602Driver, MakesTheStampOfAMissedEdgeFromItsNeighbour) {
  EXPECT_EQ(run_period(false), Status::kOk);
  EXPECT_EQ(run_period(), Status::kOk);
  expect_samples(2);
  EXPECT_EQ(driver_.counters().guessed, 1u);
}

TEST_F(Icm20602Driver, SaysThatSamplesWereLostAndGoesOn) {
  for (int i = 0; i < 80; ++i, t_ += Icm20602::kPeriod) measure();  // the FIFO holds 72
  EXPECT_EQ(run_period(), Status::kOk);
  EXPECT_EQ(chip_.fifo_size(), 0u);
  EXPECT_GE(driver_.counters().lost, 80u);
  EXPECT_EQ(run_period(), Status::kOk);
  ImuSample sample;
  ASSERT_EQ(driver_.poll(sample), Status::kFull);
  EXPECT_EQ(sample.t, 81 * Icm20602::kPeriod);
  EXPECT_EQ(driver_.poll(sample), Status::kEmpty);
}

TEST_F(Icm20602Driver, SeesAResetAndRecoversByANewSetUp) {
  EXPECT_EQ(run_period(), Status::kOk);
  chip_.memory(icm20602::kGYRO_CONFIG) = 0;  // somebody changed one register
  Status status = Status::kOk;
  int periods = 0;
  for (; status == Status::kOk && periods < 20; ++periods) status = run_period();
  EXPECT_EQ(status, Status::kBadData);
  EXPECT_LE(periods, 11) << "one row after each batch";
  ASSERT_EQ(driver_.set_up(), Status::kOk);
  chip_.reset();  // asleep: no edges any more
  status = Status::kOk;
  for (int i = 0; status == Status::kOk && i < 20; ++i) {
    t_ = now() + i * 10 * kMs;
    status = driver_.step(t_);
  }
  EXPECT_EQ(status, Status::kStale);
}

TEST_F(Icm20602Driver, TriesAFailedTransferAgain) {
  measure();
  t_ += kMs / 4;
  EXPECT_EQ(driver_.step(t_), Status::kOk);
  emulated::i2c_fail_next(Status::kTimeout);
  EXPECT_EQ(driver_.step(t_), Status::kOk);
  EXPECT_EQ(driver_.step(t_), Status::kTimeout);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(driver_.step(t_), Status::kOk);
  expect_samples(1);
}

TEST_F(Icm20602Driver, KnowsAnotherChip) {
  chip_.memory(icm20602::kWHO_AM_I) = 0x70;
  EXPECT_EQ(driver_.set_up(), Status::kNotFound);
  EXPECT_EQ(Icm20602(kBus, 0x69).set_up(), Status::kBusFault);
}

}  // namespace
}  // namespace pirvs::bsp
