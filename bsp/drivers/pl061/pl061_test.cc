#include "bsp/drivers/pl061/pl061.h"

#include <gtest/gtest.h>

#include "bsp/drivers/emulated/bus.h"
#include "bsp/drivers/pl061/pl061_emulator.h"

namespace pirvs::bsp {
namespace {

class Pl061Driver : public testing::Test {
 protected:
  static constexpr uintptr_t kBase = 0x0903'0000;
  emulated::Pl061Chip chip_;
  emulated::Attachment attachment_{kBase, chip_};
  EdgeQueues edges_;
  Pl061 driver_{kBase, 0, edges_};

  void expect_edge(TimeNs t, uint8_t line, bool level, Status status = Status::kOk) {
    GpioEdge edge;
    EXPECT_EQ(edges_.poll({0, line}, edge), status);
    EXPECT_EQ(edge.t, t);
    EXPECT_EQ(edge.pin.line, line);
    EXPECT_EQ(edge.level, level);
  }
  void expect_no_edge(uint8_t line) {
    GpioEdge edge;
    EXPECT_EQ(edges_.poll({0, line}, edge), Status::kEmpty);
  }
};

TEST_F(Pl061Driver, WritesOneOutputAndLeavesTheOthers) {
  EXPECT_EQ(driver_.direction(3, PinDirection::kOutput, true), Status::kOk);
  EXPECT_EQ(driver_.direction(5, PinDirection::kOutput, false), Status::kOk);
  EXPECT_TRUE(chip_.output(3));
  EXPECT_FALSE(chip_.output(5));
  EXPECT_EQ(driver_.write(5, true), Status::kOk);
  EXPECT_EQ(driver_.write(3, false), Status::kOk);
  EXPECT_FALSE(chip_.output(3));
  EXPECT_TRUE(chip_.output(5));
  EXPECT_TRUE(driver_.read(5).value());
}

TEST_F(Pl061Driver, ReadsInputs) {
  EXPECT_EQ(driver_.direction(2, PinDirection::kInput, false), Status::kOk);
  chip_.set_input(2, true);
  EXPECT_TRUE(driver_.read(2).value());
  EXPECT_FALSE(driver_.read(1).value());
}

TEST_F(Pl061Driver, ReportsTheWatchedEdgesAlone) {
  EXPECT_EQ(driver_.watch(1, EdgeKind::kRising), Status::kOk);
  EXPECT_EQ(driver_.watch(2, EdgeKind::kFalling), Status::kOk);
  chip_.set_input(2, true);
  EXPECT_FALSE(chip_.interrupt());
  chip_.set_input(1, true);
  EXPECT_TRUE(chip_.interrupt());
  driver_.handle_interrupt(100);
  EXPECT_FALSE(chip_.interrupt());
  expect_edge(100, 1, true);
  chip_.set_input(1, false);
  EXPECT_FALSE(chip_.interrupt());
  chip_.set_input(2, false);
  driver_.handle_interrupt(200);
  expect_edge(200, 2, false);
  expect_no_edge(1);
  expect_no_edge(2);
}

TEST_F(Pl061Driver, ReportsBothEdgesWithTheirLevel) {
  EXPECT_EQ(driver_.watch(7, EdgeKind::kBoth), Status::kOk);
  for (int i = 0; i < 4; ++i) {
    const bool level = i % 2 == 0;
    chip_.set_input(7, level);
    ASSERT_TRUE(chip_.interrupt());
    driver_.handle_interrupt(i);
    expect_edge(i, 7, level);
  }
}

TEST_F(Pl061Driver, ReportsAPulseThatIsOverBeforeTheHandlerRan) {
  EXPECT_EQ(driver_.watch(0, EdgeKind::kRising), Status::kOk);
  chip_.set_input(0, true);
  chip_.set_input(0, false);
  driver_.handle_interrupt(1);
  expect_edge(1, 0, true);
}

TEST_F(Pl061Driver, ForgetsOldEdgesWhenAWatchBegins) {
  EXPECT_EQ(driver_.watch(4, EdgeKind::kBoth), Status::kOk);
  chip_.set_input(4, true);
  EXPECT_EQ(driver_.watch(4, EdgeKind::kRising), Status::kOk);
  EXPECT_FALSE(chip_.interrupt());
  EXPECT_EQ(driver_.watch(4, EdgeKind::kNone), Status::kOk);
  chip_.set_input(4, false);
  chip_.set_input(4, true);
  EXPECT_FALSE(chip_.interrupt());
}

TEST_F(Pl061Driver, CountsLostEdgesAndSaysSoOnce) {
  EXPECT_EQ(driver_.watch(6, EdgeKind::kBoth), Status::kOk);
  for (int i = 0; i < 34; ++i) {
    chip_.set_input(6, i % 2 == 0);
    driver_.handle_interrupt(i);
  }
  expect_edge(0, 6, true, Status::kFull);
  expect_edge(1, 6, false);
}

TEST_F(Pl061Driver, EachPinHasAQueueOfItsOwn) {
  EXPECT_EQ(driver_.watch(6, EdgeKind::kBoth), Status::kOk);
  EXPECT_EQ(driver_.watch(2, EdgeKind::kRising), Status::kOk);
  for (int i = 0; i < 40; ++i) {
    chip_.set_input(6, i % 2 == 0);
    driver_.handle_interrupt(i);
  }
  chip_.set_input(2, true);
  driver_.handle_interrupt(50);
  expect_edge(50, 2, true);
  expect_no_edge(2);
  expect_edge(0, 6, true, Status::kFull);
  GpioEdge edge;
  EXPECT_EQ(edges_.poll({0, 3}, edge), Status::kNotFound) << "not watched";
  EXPECT_EQ(edges_.poll({1, 6}, edge), Status::kNotFound) << "of another bank";
}

TEST_F(Pl061Driver, WatchesNoMorePinsThanThereAreQueues) {
  EdgeQueues queues;
  for (uint8_t line = 0; line < kPinsWatchedMax; ++line) {
    EXPECT_EQ(queues.watch({3, line}), Status::kOk);
    EXPECT_EQ(queues.watch({3, line}), Status::kOk) << "again: the same queue";
  }
  EXPECT_EQ(queues.watch({3, 100}), Status::kFull);
}

TEST_F(Pl061Driver, KnowsItsLines) {
  EXPECT_EQ(driver_.direction(8, PinDirection::kInput, false), Status::kNotFound);
  EXPECT_EQ(driver_.write(8, true), Status::kNotFound);
  EXPECT_EQ(driver_.read(8).status(), Status::kNotFound);
  EXPECT_EQ(driver_.watch(8, EdgeKind::kBoth), Status::kNotFound);
}

}  // namespace
}  // namespace pirvs::bsp
