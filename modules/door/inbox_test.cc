#include "modules/door/inbox.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace pirvs {
namespace {

TEST(inbox, numbers_commands_and_refuses_too_many) {
  const auto inbox = std::make_unique<Inbox>();
  Command command;
  uint32_t pushed = 0;
  while (inbox->push(command).ok()) ++pushed;
  EXPECT_GE(pushed, 16u);
  EXPECT_EQ(inbox->push(tick_at(0)), Status::kFull);
  Arrival told;
  for (uint32_t ticket = 1; ticket <= pushed; ++ticket) {
    ASSERT_TRUE(inbox->pop(told));
    EXPECT_EQ(told.kind, ArrivalKind::kCommand);
    EXPECT_EQ(told.command.ticket, ticket);
  }
  EXPECT_FALSE(inbox->pop(told));
  EXPECT_EQ(inbox->push(command).value(), pushed + 1);
}

TEST(inbox, keeps_the_order_of_each_sender) {
  constexpr int kEach = 2000;
  const auto inbox = std::make_unique<Inbox>();
  const auto send = [&](uint8_t bank) {
    for (int i = 0; i < kEach;) {
      i += inbox->push(arrival_of(bsp::GpioEdge{i, {bank, 0}, true})) == Status::kOk;
    }
  };
  std::thread a(send, uint8_t{0}), b(send, uint8_t{1});
  TimeNs next[2] = {0, 0};
  Arrival told;
  while (next[0] < kEach || next[1] < kEach) {
    if (!inbox->pop(told)) continue;
    ASSERT_EQ(told.edge.t, next[told.edge.pin.bank]++);
  }
  a.join();
  b.join();
}

}  // namespace
}  // namespace pirvs
