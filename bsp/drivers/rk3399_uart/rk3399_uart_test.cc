#include "bsp/drivers/rk3399_uart/rk3399_uart.h"

#include <gtest/gtest.h>

#include <cstring>

#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/rk3399_uart/rk3399_uart_emulator.h"

namespace pirvs::bsp {
namespace {

class Rk3399UartDriver : public testing::Test {
 protected:
  static constexpr uintptr_t kBase = 0xff1a'0000;
  emulated::Rk3399UartChip chip_;
  emulated::Attachment attachment_{kBase, chip_};
  Rk3399Uart driver_{kBase, 24'000'000};
  uint8_t data_[128] = {};
  size_t count_ = 0;
};

TEST_F(Rk3399UartDriver, MakesTheRatesThatItsClockCan) {
  EXPECT_EQ(driver_.open(1'500'000), Status::kOk);
  EXPECT_EQ(chip_.divisor(), 1u);
  EXPECT_EQ(driver_.open(115'200), Status::kOk);
  EXPECT_EQ(chip_.divisor(), 13u);
  EXPECT_EQ(driver_.open(300), Status::kOk);
  EXPECT_EQ(chip_.divisor(), 5000u);
  for (const uint32_t baud : {0u, 10u, 1'000'000u, 3'000'000u}) {
    EXPECT_EQ(driver_.open(baud), Status::kBadData) << baud;
    EXPECT_EQ(chip_.divisor(), 5000u);
  }
}

TEST_F(Rk3399UartDriver, GivesUpOnALineThatNeverFallsSilent) {
  EXPECT_EQ(driver_.open(115'200), Status::kOk);
  chip_.set_line_busy(true);
  EXPECT_EQ(driver_.open(1'500'000), Status::kTimeout);
  EXPECT_EQ(chip_.divisor(), 13u);
}

TEST_F(Rk3399UartDriver, WritesWhatFitsAndSaysHowMuch) {
  ASSERT_EQ(driver_.open(1'500'000), Status::kOk);
  uint8_t text[100];
  for (size_t i = 0; i < sizeof text; ++i) text[i] = static_cast<uint8_t>(i);
  EXPECT_EQ(driver_.write(text, sizeof text), 64u);
  EXPECT_EQ(driver_.write(text + 64, 36), 0u);
  chip_.send_out(10);
  EXPECT_EQ(driver_.write(text + 64, 36), 10u);
  chip_.send_out(100);
  EXPECT_EQ(driver_.write(text + 74, 26), 26u);
  chip_.send_out(100);
  ASSERT_EQ(chip_.sent_size(), sizeof text);
  EXPECT_EQ(std::memcmp(chip_.sent(), text, sizeof text), 0);
}

TEST_F(Rk3399UartDriver, ReadsInOrderUntilNothingIsLeft) {
  ASSERT_EQ(driver_.open(1'500'000), Status::kOk);
  EXPECT_EQ(driver_.read(data_, sizeof data_, count_), Status::kEmpty);
  for (const char c : {'a', 'b', 'c'}) chip_.receive(static_cast<uint8_t>(c));
  EXPECT_EQ(driver_.read(data_, 2, count_), Status::kOk);
  EXPECT_EQ(count_, 2u);
  EXPECT_EQ(driver_.read(data_ + 2, sizeof data_ - 2, count_), Status::kOk);
  EXPECT_EQ(count_, 1u);
  EXPECT_EQ(std::memcmp(data_, "abc", 3), 0);
}

TEST_F(Rk3399UartDriver, SaysThatBytesWereLost) {
  ASSERT_EQ(driver_.open(1'500'000), Status::kOk);
  for (int i = 0; i < 65; ++i) chip_.receive(static_cast<uint8_t>(i));
  EXPECT_EQ(driver_.read(data_, sizeof data_, count_), Status::kFull);
  EXPECT_EQ(count_, 64u);
  EXPECT_EQ(driver_.read(data_, sizeof data_, count_), Status::kEmpty);
}

TEST_F(Rk3399UartDriver, DropsADamagedByteAlone) {
  using namespace rk3399_uart;
  ASSERT_EQ(driver_.open(1'500'000), Status::kOk);
  chip_.receive('x');
  chip_.receive('?', kLsrFraming);
  chip_.receive('y');
  EXPECT_EQ(driver_.read(data_, sizeof data_, count_), Status::kBadData);
  EXPECT_EQ(count_, 2u);
  EXPECT_EQ(std::memcmp(data_, "xy", 2), 0);
}

TEST_F(Rk3399UartDriver, OpeningForgetsOldBytes) {
  chip_.receive('x');
  ASSERT_EQ(driver_.open(1'500'000), Status::kOk);
  EXPECT_EQ(driver_.read(data_, sizeof data_, count_), Status::kEmpty);
}

}  // namespace
}  // namespace pirvs::bsp
