#include "core/config/key_values.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace pirvs {
namespace {

struct Read {
  std::vector<KeyValue> lines;
  ConfigFault fault;
};

Read read(std::string_view text) {
  Read out;
  KeyValues lines(text);
  KeyValue line;
  Status status = Status::kOk;
  while ((status = lines.next(line)) == Status::kOk) out.lines.push_back(line);
  EXPECT_EQ(status, lines.fault() ? Status::kBadData : Status::kStale);
  EXPECT_EQ(lines.next(line), status) << "an end stays an end";
  out.fault = lines.fault();
  return out;
}

TEST(KeyValues, ReadsWhatAPersonWrites) {
  const Read got = read(
      "\xef\xbb\xbf# the device\r\n\r\n  camera.left=/dev/video0\r\n"
      "parameter.door.pair_s =\t0.01  # free-running\n#x = y\nlast = a = b");
  ASSERT_FALSE(got.fault);
  ASSERT_EQ(got.lines.size(), 3u);
  EXPECT_EQ(got.lines[0].key, "camera.left");
  EXPECT_EQ(got.lines[0].value, "/dev/video0");
  EXPECT_EQ(got.lines[0].line, 3);
  EXPECT_EQ(got.lines[1].value, "0.01");
  EXPECT_EQ(got.lines[2].key, "last");
  EXPECT_EQ(got.lines[2].value, "a = b");
  EXPECT_EQ(got.lines[2].line, 6);
  EXPECT_TRUE(read("").lines.empty());
}

TEST(KeyValues, SaysWhichLineIsBrokenAndHow) {
  struct Broken {
    std::string text;
    int line;
    const char* what;
  };
  const Broken kBroken[] = {
      {"a = 1\nb", 2, "not `key = value`"},
      {"= 1", 1, "no key before `=`"},
      {"a = 1\n\nb =   # none\n", 3, "no value behind `=`"},
      {"a b = 1", 1, "a key has letters, digits, . _ - alone"},
      {"\xc3\xa4 = 1", 1, "a key has letters, digits, . _ - alone"},
      {"a = 1\nb = 2\na = 1", 3, "the key stands there twice"},
      {std::string("a = \0", 5), 1, "bytes that are no text"},
      {"a = \x1b[1m", 1, "bytes that are no text"},
      {"a = " + std::string(600, '1'), 1, "a line longer than 512 bytes"},
      {"#" + std::string(600, '1'), 1, "a line longer than 512 bytes"},
  };
  for (const Broken& broken : kBroken) {
    const Read got = read(broken.text);
    ASSERT_TRUE(got.fault) << broken.text;
    EXPECT_EQ(got.fault.line, broken.line) << broken.text;
    EXPECT_STREQ(got.fault.what, broken.what) << broken.text;
  }
}

TEST(KeyValues, AFaultIsOneLine) {
  Text<160> line;
  put_fault(line, "device.cfg", {7, "not a number", "camera.exposure_us"});
  EXPECT_STREQ(line.c_str(), "device.cfg:7: not a number: camera.exposure_us");
  line.clear();
  put_fault(line, "device.cfg", {0, "no camera", {}});
  EXPECT_STREQ(line.c_str(), "device.cfg: no camera");
}

TEST(KeyValues, ValuesAreReadWholeOrNotAtAll) {
  double numbers[3] = {7, 7, 7};
  EXPECT_TRUE(read_numbers("1, -2.5\t3e2", numbers, 3));
  EXPECT_EQ(numbers[1], -2.5);
  for (const char* bad : {"1 2", "1 2 3 4", "1 2 x", "1 2 nan", "1 2 1e999", ""}) {
    EXPECT_FALSE(read_numbers(bad, numbers, 3)) << bad;
  }
  EXPECT_EQ(numbers[2], 300);
  int64_t whole = 5;
  EXPECT_TRUE(read_whole("65535", 1, 65535, whole));
  for (const char* bad : {"0", "65536", "1.5", "x", "1 2", "1e300", "-1"}) {
    EXPECT_FALSE(read_whole(bad, 1, 65535, whole)) << bad;
  }
  EXPECT_EQ(whole, 65535);
  bool yes = false;
  EXPECT_TRUE(read_yes_no("yes", yes));
  EXPECT_FALSE(read_yes_no("Yes", yes));
  EXPECT_TRUE(yes);
}

}  // namespace
}  // namespace pirvs
