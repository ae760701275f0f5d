#include "bsp/drivers/rk3399_gpio/rk3399_gpio.h"

#include <gtest/gtest.h>

#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/rk3399_gpio/rk3399_gpio_emulator.h"

namespace pirvs::bsp {
namespace {

static_assert(rk3399_line('A', 0) == 0 && rk3399_line('C', 2) == 18 && rk3399_line('D', 7) == 31);

class Rk3399GpioDriver : public testing::Test {
 protected:
  static constexpr uintptr_t kBase = 0xff79'0000;
  emulated::Rk3399GpioChip chip_;
  emulated::Attachment attachment_{kBase, chip_};
  EdgeQueues edges_;
  Rk3399Gpio driver_{kBase, 4, edges_};

  void expect_edge(TimeNs t, uint8_t line, bool level) {
    GpioEdge edge;
    EXPECT_EQ(edges_.poll({4, line}, edge), Status::kOk);
    EXPECT_EQ(edge.t, t);
    EXPECT_EQ(edge.pin.bank, 4);
    EXPECT_EQ(edge.pin.line, line);
    EXPECT_EQ(edge.level, level);
  }
  void expect_no_edge(uint8_t line) {
    GpioEdge edge;
    EXPECT_EQ(edges_.poll({4, line}, edge), Status::kEmpty);
  }
};

TEST_F(Rk3399GpioDriver, WritesOneOutputAndLeavesTheOthers) {
  EXPECT_EQ(driver_.direction(18, PinDirection::kOutput, true), Status::kOk);
  EXPECT_EQ(driver_.direction(31, PinDirection::kOutput, false), Status::kOk);
  EXPECT_TRUE(chip_.output(18));
  EXPECT_FALSE(chip_.output(31));
  EXPECT_EQ(driver_.write(31, true), Status::kOk);
  EXPECT_EQ(driver_.write(18, false), Status::kOk);
  EXPECT_FALSE(driver_.read(18).value());
  EXPECT_TRUE(driver_.read(31).value());
}

TEST_F(Rk3399GpioDriver, ReportsTheWatchedEdgesAlone) {
  EXPECT_EQ(driver_.watch(1, EdgeKind::kRising), Status::kOk);
  EXPECT_EQ(driver_.watch(30, EdgeKind::kFalling), Status::kOk);
  chip_.set_input(30, true);
  EXPECT_FALSE(chip_.interrupt());
  chip_.set_input(1, true);
  chip_.set_input(1, false);  // the pulse is over, its edge is latched
  ASSERT_TRUE(chip_.interrupt());
  driver_.handle_interrupt(5);
  EXPECT_FALSE(chip_.interrupt());
  expect_edge(5, 1, true);
  chip_.set_input(30, false);
  driver_.handle_interrupt(6);
  expect_edge(6, 30, false);
  expect_no_edge(1);
  expect_no_edge(30);
}

TEST_F(Rk3399GpioDriver, ReportsBothEdgesFromEitherLevel) {
  for (const bool begin : {false, true}) {
    chip_.set_input(9, begin);
    EXPECT_EQ(driver_.watch(9, EdgeKind::kBoth), Status::kOk);
    ASSERT_FALSE(chip_.interrupt());
    for (int i = 0; i < 4; ++i) {
      const bool level = begin != (i % 2 == 0);
      chip_.set_input(9, level);
      ASSERT_TRUE(chip_.interrupt());
      driver_.handle_interrupt(i);
      expect_edge(i, 9, level);
      ASSERT_FALSE(chip_.interrupt());
    }
  }
}

TEST_F(Rk3399GpioDriver, ReportsTheWayBackThatCameWhileTheHandlerRan) {
  EXPECT_EQ(driver_.watch(9, EdgeKind::kBoth), Status::kOk);
  chip_.set_input(9, true);
  driver_.handle_interrupt(1);
  chip_.set_input(9, false);  // before the handler has returned
  ASSERT_TRUE(chip_.interrupt());
  driver_.handle_interrupt(2);
  expect_edge(1, 9, true);
  expect_edge(2, 9, false);
  EXPECT_FALSE(chip_.interrupt());
}

TEST_F(Rk3399GpioDriver, AnEdgeDoesNotTurnAroundAnotherPin) {
  EXPECT_EQ(driver_.watch(9, EdgeKind::kBoth), Status::kOk);
  EXPECT_EQ(driver_.watch(10, EdgeKind::kRising), Status::kOk);
  chip_.set_input(10, true);
  driver_.handle_interrupt(1);
  expect_edge(1, 10, true);
  EXPECT_FALSE(chip_.interrupt());
  EXPECT_EQ(driver_.watch(9, EdgeKind::kNone), Status::kOk);
  chip_.set_input(9, true);
  EXPECT_FALSE(chip_.interrupt());
}

TEST_F(Rk3399GpioDriver, KnowsItsLines) {
  EXPECT_EQ(driver_.direction(32, PinDirection::kInput, false), Status::kNotFound);
  EXPECT_EQ(driver_.write(32, true), Status::kNotFound);
  EXPECT_EQ(driver_.read(32).status(), Status::kNotFound);
  EXPECT_EQ(driver_.watch(32, EdgeKind::kBoth), Status::kNotFound);
}

}  // namespace
}  // namespace pirvs::bsp
