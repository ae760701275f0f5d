#include "bsp/drivers/pl011/pl011.h"

#include <gtest/gtest.h>

#include <string>

#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/pl011/pl011_emulator.h"

namespace pirvs::bsp {
namespace {

class Pl011Driver : public testing::Test {
 protected:
  static constexpr uintptr_t kBase = 0x0900'0000;
  emulated::Pl011Chip chip_;
  emulated::Attachment attachment_{kBase, chip_};
  Pl011 driver_{kBase};
};

// Longer than the FIFO: the driver has to wait for the line. The last characters are still in the
// FIFO, and leave it while the driver looks for input.
TEST_F(Pl011Driver, WritesEveryCharacterInOrder) {
  driver_.start();
  std::string text;
  for (int i = 0; i < 100; ++i) text += static_cast<char>('0' + i % 75);
  for (const char c : text) driver_.write(c);
  for (size_t i = 0; i < emulated::Pl011Chip::kFifo; ++i) EXPECT_EQ(driver_.read(), -1);
  EXPECT_EQ(chip_.sent(), text);
}

TEST_F(Pl011Driver, ReadsWhatHasComeAndNothingElse) {
  driver_.start();
  EXPECT_EQ(driver_.read(), -1);
  EXPECT_TRUE(chip_.receive('a'));
  EXPECT_TRUE(chip_.receive('\xe9'));
  EXPECT_EQ(driver_.read(), 'a');
  EXPECT_EQ(driver_.read(), 0xe9);
  EXPECT_EQ(driver_.read(), -1);
}

TEST_F(Pl011Driver, CanBeStartedAgain) {
  driver_.start();
  driver_.start();  // the emulator asserts on settings changed while the port is on
  EXPECT_DEATH(chip_.write(pl011::kUARTLCR_H.offset, 0), "bug");
}

}  // namespace
}  // namespace pirvs::bsp
