#include "bsp/drivers/rk3399_i2c/rk3399_i2c.h"

#include <gtest/gtest.h>

#include <cstring>

#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/rk3399_i2c/rk3399_i2c_emulator.h"

namespace pirvs::bsp {
namespace {

constexpr uint32_t kClock_hz = 198'000'000;
constexpr uint8_t kAddress = 0x68;

class Rk3399I2cDriver : public testing::Test {
 protected:
  static constexpr uintptr_t kBase = 0xff11'0000;
  emulated::I2cDevice device_{kAddress};
  emulated::Rk3399I2cChip chip_{device_};
  emulated::Attachment attachment_{kBase, chip_};
  Rk3399I2c driver_{kBase, kClock_hz};
  uint8_t in_[100] = {};
  int polls_ = 0;

  void SetUp() override {
    ASSERT_EQ(driver_.open(400'000), Status::kOk);
    for (int i = 0; i < 256; ++i) device_.memory[i] = static_cast<uint8_t>(i);
  }

  Status run(const I2cTransfer& transfer) {
    polls_ = 0;
    PIRVS_TRY(driver_.start(transfer, 0));
    Status status = Status::kEmpty;
    for (; status == Status::kEmpty && polls_ < 1000; ++polls_) status = driver_.poll(polls_);
    return status;
  }
  Status read_from(uint8_t place, size_t size, uint8_t address = kAddress) {
    return run({address, &place, 1, in_, size});
  }
};

TEST_F(Rk3399I2cDriver, KeepsTheRateBelowWhatWasAsked) {
  for (const uint32_t scl_hz : {100'000u, 400'000u, 1'000'000u}) {
    EXPECT_EQ(driver_.open(scl_hz), Status::kOk);
    EXPECT_LE(chip_.scl_hz(kClock_hz), scl_hz);
    EXPECT_GE(chip_.scl_hz(kClock_hz), scl_hz * 0.95);
  }
  EXPECT_EQ(driver_.open(0), Status::kBadData);
  EXPECT_EQ(driver_.open(100), Status::kBadData);
  EXPECT_EQ(driver_.open(kClock_hz), Status::kBadData);
}

TEST_F(Rk3399I2cDriver, ReadsAnyNumberOfBytesFromARegister) {
  for (const size_t size : {1, 3, 4, 31, 32, 33, 64, 65, 100}) {
    std::memset(in_, 0xee, sizeof in_);
    ASSERT_EQ(read_from(5, size), Status::kOk) << size;
    for (size_t i = 0; i < size; ++i) EXPECT_EQ(in_[i], 5 + i) << size;
    if (size < sizeof in_) {
      EXPECT_EQ(in_[size], 0xee) << size;
    }
    EXPECT_TRUE(device_.was_released) << size;
  }
}

TEST_F(Rk3399I2cDriver, WritesAnyNumberOfBytes) {
  for (const size_t size : {1, 2, 30, 31, 32, 33, 63, 64, 65}) {
    std::memset(device_.memory, 0, sizeof device_.memory);
    uint8_t out[66] = {7};
    for (size_t i = 1; i <= size; ++i) out[i] = static_cast<uint8_t>(100 + i);
    ASSERT_EQ(run({kAddress, out, size + 1, nullptr, 0}), Status::kOk) << size;
    EXPECT_EQ(std::memcmp(device_.memory + 7, out + 1, size), 0) << size;
    EXPECT_EQ(device_.memory[7 + size], 0) << size;
  }
}

TEST_F(Rk3399I2cDriver, ReadsOnFromWhereTheChipIs) {
  ASSERT_EQ(read_from(10, 2), Status::kOk);
  ASSERT_EQ(run({kAddress, nullptr, 0, in_, 3}), Status::kOk);
  EXPECT_EQ(in_[0], 12);
  EXPECT_EQ(in_[2], 14);
}

TEST_F(Rk3399I2cDriver, WaitsBetweenPolls) {
  ASSERT_EQ(read_from(0, 1), Status::kOk);
  EXPECT_GE(polls_, 6);  // start, data and stop, each seen at the second look
}

TEST_F(Rk3399I2cDriver, SaysThatNobodyAnswered) {
  EXPECT_EQ(read_from(0, 4, 0x69), Status::kBusFault);
  const uint8_t out[2] = {1, 2};
  EXPECT_EQ(run({0x69, out, 2, nullptr, 0}), Status::kBusFault);
  EXPECT_EQ(device_.memory[1], 1);
  EXPECT_EQ(read_from(9, 1), Status::kOk);  // the bus is free again
  EXPECT_EQ(in_[0], 9);
}

TEST_F(Rk3399I2cDriver, SaysThatAByteWasRefused) {
  const uint8_t out[4] = {1, 2, 3, 4};
  device_.refuse_after = 2;
  EXPECT_EQ(run({kAddress, out, 4, nullptr, 0}), Status::kBusFault);
  device_.refuse_after = 0;
  EXPECT_EQ(read_from(1, 4), Status::kBusFault);
}

TEST_F(Rk3399I2cDriver, EndsAndRecoversWhenTheBusIsHeld) {
  chip_.hold_bus(true);
  const uint8_t place = 3;
  ASSERT_EQ(driver_.start({kAddress, &place, 1, in_, 1}, 1000), Status::kOk);
  EXPECT_EQ(driver_.poll(1000), Status::kEmpty);
  EXPECT_EQ(driver_.poll(1000 + kI2cTimeout), Status::kEmpty);
  EXPECT_EQ(driver_.poll(1001 + kI2cTimeout), Status::kTimeout);
  EXPECT_EQ(driver_.poll(1002 + kI2cTimeout), Status::kStale);
  chip_.hold_bus(false);
  EXPECT_EQ(read_from(3, 1), Status::kOk);
  EXPECT_EQ(in_[0], 3);
}

TEST_F(Rk3399I2cDriver, RefusesWhatItCannotDo) {
  const uint8_t out[4] = {};
  EXPECT_EQ(driver_.start({kAddress, out, 4, in_, 1}, 0), Status::kBadData);
  EXPECT_EQ(driver_.start({kAddress, nullptr, 0, nullptr, 0}, 0), Status::kBadData);
  EXPECT_EQ(driver_.poll(0), Status::kStale);
  EXPECT_EQ(driver_.start({kAddress, out, 1, in_, 1}, 0), Status::kOk);
  EXPECT_EQ(driver_.start({kAddress, out, 1, in_, 1}, 0), Status::kFull);
}

}  // namespace
}  // namespace pirvs::bsp
