#include "board/linux/text_commands.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace pirvs::board {
namespace {

struct Lines {
  std::vector<std::string> whole;
  int bad = 0;
};

Lines read_lines(const std::string& bytes) {
  Lines out;
  LineReader reader;
  for (const char c : bytes) {
    const LineReader::Taken taken = reader.take(c);
    if (taken == LineReader::Taken::kLine) out.whole.emplace_back(reader.line());
    out.bad += taken == LineReader::Taken::kBad;
  }
  return out;
}

TEST(LineReader, EndsALineAtCrAtLfAndAtBoth) {
  const Lines lines = read_lines("one\ntwo\rthree\r\nfour");
  EXPECT_EQ(lines.whole, (std::vector<std::string>{"one", "two", "three", ""}));
  EXPECT_EQ(lines.bad, 0);
}

TEST(LineReader, RefusesALineTooLongWholeAndGoesOn) {
  const std::string longest(LineReader::kLineMax, 'x');
  const Lines lines = read_lines(longest + "\n" + longest + "y\n" + "stop\n");
  EXPECT_EQ(lines.whole, (std::vector<std::string>{longest, "stop"}));
  EXPECT_EQ(lines.bad, 1);
}

TEST(LineReader, RefusesWhatIsNoTextAndGoesOn) {
  const Lines lines = read_lines(std::string("st\0p\n", 5) + "\x7f\n\xc3\xa4\nre\tset\n");
  EXPECT_EQ(lines.whole, (std::vector<std::string>{"re\tset"}));
  EXPECT_EQ(lines.bad, 3);
}

CommandKind kind_of(const char* line) {
  const TextRequest request = read_request(line);
  EXPECT_EQ(request.kind, RequestKind::kCommand) << line;
  return request.command.kind;
}

TEST(TextCommands, ReadsEachCommand) {
  EXPECT_EQ(kind_of("stop"), CommandKind::kStop);
  EXPECT_EQ(kind_of("  reset  "), CommandKind::kReset);
  EXPECT_EQ(kind_of("record start"), CommandKind::kStartRecording);
  EXPECT_EQ(kind_of("record\tstop"), CommandKind::kStopRecording);
  EXPECT_EQ(kind_of("map save"), CommandKind::kSaveMap);
  EXPECT_EQ(kind_of("map load hall-2.bin"), CommandKind::kLoadMap);
  EXPECT_EQ(kind_of("node set dock"), CommandKind::kSetNode);
  EXPECT_EQ(kind_of("node get dock"), CommandKind::kGetNode);
  EXPECT_EQ(kind_of("node remove dock"), CommandKind::kRemoveNode);
  EXPECT_EQ(read_request("counters").kind, RequestKind::kCounters);
  EXPECT_EQ(read_request("pose").kind, RequestKind::kPose);
  EXPECT_EQ(read_request("help").kind, RequestKind::kHelp);
  EXPECT_EQ(read_request("").kind, RequestKind::kNone);
  EXPECT_EQ(read_request(" \t ").kind, RequestKind::kNone);
  EXPECT_FALSE(read_request("poses off").on);
  EXPECT_TRUE(read_request("poses on").on);
}

TEST(TextCommands, ReadsWhatACommandNeeds) {
  const TextRequest parameter = read_request("parameter frontend.tracks_target 1.5e2");
  ASSERT_EQ(parameter.kind, RequestKind::kCommand);
  EXPECT_STREQ(parameter.command.text, "frontend.tracks_target");
  EXPECT_EQ(parameter.command.value, 150);
  EXPECT_STREQ(read_request("map save").command.text, "map.bin");
  EXPECT_STREQ(read_request("map load a_1").command.text, "a_1");
  const TextRequest pose = read_request("pose 1 -2 0.5 90");
  ASSERT_EQ(pose.kind, RequestKind::kCommand);
  EXPECT_EQ(pose.command.kind, CommandKind::kSetPose);
  EXPECT_EQ(pose.command.p_WB, Vec3(1, -2, 0.5));
  EXPECT_NEAR(pose.command.yaw_rad, 1.5707963, 1e-6);
  EXPECT_EQ(pose.command.value, 0);
  EXPECT_EQ(read_request("pose 1 -2 0.5 90 0.25").command.value, 0.25f);
  const TextRequest node = read_request("node set dock 1 -2 0.5 90");
  EXPECT_STREQ(node.command.text, "dock");
  EXPECT_EQ(node.command.p_WB, Vec3(1, -2, 0.5));
  EXPECT_EQ(node.command.value, 1) << "there";
  EXPECT_EQ(read_request("node set dock").command.value, 0) << "here";
}

TEST(TextCommands, RefusesEverythingElseWithAReason) {
  const std::string long_name(Command::kTextMax, 'n');
  for (const std::string& line : {std::string("go"),
                                  std::string("stop now"),
                                  std::string("record"),
                                  std::string("record it"),
                                  std::string("parameter a.b"),
                                  std::string("parameter a.b high"),
                                  std::string("parameter a.b 1 2"),
                                  "parameter " + long_name + " 1",
                                  std::string("pose 1 2 3"),
                                  std::string("pose 1 2 3 x"),
                                  std::string("pose 1 2 3 4 0"),
                                  std::string("pose 1 2 3 4 5 6"),
                                  std::string("node"),
                                  std::string("node set"),
                                  std::string("node set a/b"),
                                  std::string("node set a 1 2 3"),
                                  std::string("node get a 1 2 3 4"),
                                  std::string("node hide a"),
                                  std::string("poses"),
                                  std::string("poses maybe"),
                                  std::string("map"),
                                  std::string("map load ../secret"),
                                  std::string("map load .hidden"),
                                  std::string("map load a/b"),
                                  "map save " + long_name,
                                  std::string("map save a b"),
                                  std::string("STOP"),
                                  std::string("a b c d e f g h i")}) {
    const TextRequest request = read_request(line);
    EXPECT_EQ(request.kind, RequestKind::kBad) << line;
    EXPECT_NE(request.why, nullptr) << line;
  }
}

// A host that only listens, with its terminal as it is by default, sends all back that it hears.
TEST(TextCommands, IsDeafToItsOwnLines) {
  for (const char* line : {"12.5 0 0 0 0 0 0 1 tracking 0.90", "-1.5 2", "ok stop", "error pose",
                           "  ok counters a=1", "error no such command, see help"}) {
    EXPECT_TRUE(is_echo(line)) << line;
    EXPECT_EQ(read_request(line).kind, RequestKind::kNone) << line;
  }
  for (const char* line : {"", "stop", "okay", "errors", "pose 1 2 3 4"}) {
    EXPECT_FALSE(is_echo(line)) << line;
  }
}

TEST(TextCommands, AnswersInOneLine) {
  Text<256> out;
  put_answer(out, {1, CommandKind::kSaveMap, Status::kOk, SE3{}});
  EXPECT_STREQ(out.c_str(), "ok map save");
  out.clear();
  put_answer(out, {2, CommandKind::kStartRecording, Status::kFull, SE3{}});
  EXPECT_STREQ(out.c_str(), "error record start: full");
  out.clear();
  put_answer(out, {3, CommandKind::kGetNode, Status::kOk, {Mat3::Identity(), Vec3(1, -2, 0.5)}});
  EXPECT_STREQ(out.c_str(),
               "ok node get 1.000000 -2.000000 0.500000 0.000000 0.000000 0.000000 1.000000");
  out.clear();
  put_help(out);
  EXPECT_EQ(std::string(out.c_str()).rfind("ok ", 0), 0u);
  EXPECT_FALSE(out.full());
}

// Whatever comes, nothing is read beyond a line and each line has a verdict.
TEST(TextCommands, SurvivesGarbage) {
  constexpr const char* kPieces[] = {"stop", "map",  "save", "load", "parameter", "pose",
                                     "on",   "1e99", "-",    ".",    "\r\n",      "\n",
                                     " ",    "\t",   "\x01", "\xff", "frontend."};
  std::minstd_rand random(1);
  LineReader reader;
  int lines = 0;
  for (int i = 0; i < 20'000; ++i) {
    for (const char* c = kPieces[random() % std::size(kPieces)]; *c != 0; ++c) {
      if (reader.take(*c) != LineReader::Taken::kLine) continue;
      const TextRequest request = read_request(reader.line());
      ++lines;
      EXPECT_EQ(request.kind == RequestKind::kBad, request.why != nullptr) << reader.line();
    }
  }
  EXPECT_GT(lines, 500);
}

}  // namespace
}  // namespace pirvs::board
