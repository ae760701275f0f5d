#include "board/linux/serial_link.h"

#include <gtest/gtest.h>
#include <termios.h>

#include <string>
#include <vector>

#include "board/linux/testing_line_test.h"

namespace pirvs::board {
namespace {

constexpr TimeNs kMs = 1'000'000;

// The host's end of a line: a pseudo terminal, under a name that stays when it is another one.
class SerialLinkTest : public testing::Test {
 protected:
  void SetUp() override {
    line_.plug();
    SerialStack stack;
    stack.context = this;
    stack.command = [](void* context, const Command& command) -> Result<uint32_t> {
      auto& test = *static_cast<SerialLinkTest*>(context);
      test.commands_.push_back(command);
      if (test.full_) return Status::kFull;
      return test.ticket_++;
    };
    stack.put_counters = [](void*, TextWriter& out) { out.put(" frames=3 imu_gap=1"); };
    link_.configure(line_.path().c_str(), stack);
    poll();
  }
  void TearDown() override { link_.close(); }

  void type(const std::string& text) {
    line_.type(text);
    poll();
  }
  void poll() { link_.poll(now_ += SerialLink::kRead_ns); }
  void pose(const char* text) {
    Text<128> line;
    link_.pose(line.put(text).put('\n'));
  }
  std::string heard() { return line_.heard(); }

  SerialLink link_;
  TestingLine line_{"pirvs_tty_"};
  TimeNs now_ = 1000 * kMs;
  uint32_t ticket_ = 7;
  bool full_ = false;
  std::vector<Command> commands_;
};

TEST_F(SerialLinkTest, SendsPosesAsTheyAre) {
  pose("1.0 a");
  pose("2.0 b");
  EXPECT_EQ(heard(), "1.0 a\n2.0 b\n");
  EXPECT_EQ(link_.counters().lines, 2u);
  EXPECT_EQ(link_.counters().dropped, 0u);
}

// No echo of what comes, or two of these would talk for ever; no CR put in.
TEST_F(SerialLinkTest, MakesTheLineRaw) {
  type("garbage that is no command");
  EXPECT_EQ(heard(), "");
}

TEST_F(SerialLinkTest, HandsCommandsOnAndAnswersWhenTheyAreDone) {
  type("reset\r\nmap save hall\r\n");
  ASSERT_EQ(commands_.size(), 2u);
  EXPECT_EQ(commands_[0].kind, CommandKind::kReset);
  EXPECT_STREQ(commands_[1].text, "hall");
  EXPECT_EQ(heard(), "") << "not done yet";
  link_.answer({7, CommandKind::kReset, Status::kOk});
  link_.answer({8, CommandKind::kSaveMap, Status::kBusFault});
  link_.answer({8, CommandKind::kSaveMap, Status::kOk});  // told already
  link_.answer({99, CommandKind::kStop, Status::kOk});    // somebody else's
  EXPECT_EQ(heard(), "ok reset\nerror map save: bus fault\n");
}

TEST_F(SerialLinkTest, AnswersAtOnceWhatItKnows) {
  type("pose\n");
  pose("12.5 0 0 0 0 0 0 1 tracking 0.90");
  type("pose\ncounters\nnonsense\n");
  EXPECT_EQ(heard(),
            "error pose: there is none yet\n"
            "12.5 0 0 0 0 0 0 1 tracking 0.90\n"
            "ok pose 12.5 0 0 0 0 0 0 1 tracking 0.90\n"
            "ok counters frames=3 imu_gap=1\n"
            "error no such command, see help\n");
  EXPECT_EQ(link_.counters().commands, 3u);
  EXPECT_EQ(link_.counters().garbled, 1u);
}

// Two of these would otherwise talk for ever.
TEST_F(SerialLinkTest, DoesNotAnswerAnEcho) {
  pose("12.5 0 0 0 0 0 0 1 tracking 0.90");
  type("nonsense\ncounters\n");
  const std::string said = heard();
  type(said);
  type("ok counters" + std::string(300, 'x') + "\n");
  EXPECT_EQ(heard(), "");
}

TEST_F(SerialLinkTest, SaysWhenTheStackHasNoRoom) {
  full_ = true;
  type("reset\n");
  EXPECT_EQ(heard(), "error reset: full\n");
}

TEST_F(SerialLinkTest, KeepsQuietWhenTold) {
  type("poses off\n");
  pose("1.0 a");
  type("pose\n");
  EXPECT_EQ(heard(), "ok poses off\nok pose 1.0 a\n");
}

TEST_F(SerialLinkTest, TakesALineInPieces) {
  type("res");
  EXPECT_TRUE(commands_.empty());
  type("et\n");
  EXPECT_EQ(commands_.size(), 1u);
}

// A host that does not read: lines are lost whole, and the next one that it reads is whole again.
TEST_F(SerialLinkTest, DropsWholeLinesWhenNobodyReads) {
  constexpr int kLines = 5000;
  const std::string tail(60, '.');
  for (int i = 0; i < kLines; ++i) pose((std::to_string(i) + tail).c_str());
  EXPECT_GT(link_.counters().dropped, 0u);
  EXPECT_EQ(link_.counters().dropped + link_.counters().lines, uint32_t(kLines));
  std::string all;
  for (int i = 0; i < 100; ++i) {
    all += heard();
    poll();
  }
  pose("the end");
  all += heard();
  uint32_t lines = 0;
  for (size_t at = 0; at < all.size(); ++lines) {
    const size_t end = all.find('\n', at);
    ASSERT_NE(end, std::string::npos);
    const std::string line = all.substr(at, end - at);
    EXPECT_TRUE(line == "the end" || line.find(tail) == line.size() - tail.size()) << line;
    at = end + 1;
  }
  EXPECT_EQ(lines, link_.counters().lines);
}

TEST_F(SerialLinkTest, GoesOnWhenTheHostComesBack) {
  pose("1.0 a");
  line_.unplug();
  for (int i = 0; i < 3; ++i) poll();
  pose("2.0 b");
  line_.plug();
  for (TimeNs t = 0; t <= SerialLink::kRetry_ns; t += SerialLink::kRead_ns) poll();
  pose("3.0 c");
  EXPECT_EQ(heard(), "3.0 c\n");
  EXPECT_EQ(link_.counters().opened, 2u);
  type("reset\n");
  EXPECT_EQ(commands_.size(), 1u);
}

}  // namespace
}  // namespace pirvs::board
