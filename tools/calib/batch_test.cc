#include "tools/calib/batch.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

std::string text_of(const std::string& path) {
  std::stringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

// A program that does as the recording's name says, and counts how often it was called.
struct Night {
  std::string root = ::testing::TempDir() + "/pirvs_night";
  BatchOptions options;

  Night() {
    fs::remove_all(root);
    for (const char* serial : {"bad", "crash", "fail", "good"}) {
      fs::create_directories(root + "/in/" + serial + "/mav0");
    }
    fs::create_directories(root + "/in/notes");
    std::ofstream(root + "/pirvs") << R"(#!/bin/sh
# calib device SEQ --target T --serial S --out OUT
echo "$7" >> )" + root + R"(/calls
case "$7" in
  good) exit 0;;
  bad) echo "pirvs: no tag of the board is seen: here: look" >&2; exit 2;;
  fail) echo '{"checks": [{"what": "width", "passed": false}, {"what": "height", "passed": true},
    {"what": "depth", "passed": false}]}' > "$9/calibration.json"; exit 1;;
esac
kill -9 $$
)";
    fs::permissions(root + "/pirvs", fs::perms::owner_all);
    options.folder = root + "/in";
    options.out = root + "/out";
    options.target = root + "/target.yaml";
    options.program = root + "/pirvs";
    options.jobs = 3;
  }
  std::map<std::string, BatchRow> run() const {
    std::map<std::string, BatchRow> out;
    size_t told = 0;
    for (const BatchRow& row : run_batch(options, [&](const BatchRow&) { ++told; })) {
      out[row.serial] = row;
    }
    EXPECT_EQ(told, out.size());
    return out;
  }
  size_t calls() const {
    const std::string text = text_of(root + "/calls");
    return size_t(std::count(text.begin(), text.end(), '\n'));
  }
};

TEST(batch, says_of_each_device_how_it_went) {
  const Night night;
  auto rows = night.run();
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows["good"].verdict, Verdict::kPassed);
  EXPECT_EQ(rows["fail"].verdict, Verdict::kFailed);
  EXPECT_EQ(rows["fail"].reason, "width; depth");
  EXPECT_EQ(rows["bad"].verdict, Verdict::kRefused);
  EXPECT_EQ(rows["bad"].reason, "no tag of the board is seen: here: look");
  EXPECT_EQ(rows["crash"].verdict, Verdict::kCrashed);
  const std::string csv = text_of(night.root + "/out/batch.csv");
  EXPECT_NE(csv.find("\"bad\",refused,"), std::string::npos) << csv;
  EXPECT_NE(text_of(night.root + "/out/batch.html").find("1 of 4 devices passed"),
            std::string::npos);
}

TEST(batch, goes_on_where_it_was_stopped) {
  Night night;
  (void)night.run();
  EXPECT_EQ(night.calls(), 4u);
  auto rows = night.run();  // the one that crashed is tried again
  EXPECT_EQ(night.calls(), 5u);
  EXPECT_TRUE(rows["good"].kept);
  EXPECT_EQ(rows["fail"].reason, "width; depth");
  std::ofstream(night.root + "/out/good/outcome.json") << "{ half";  // the disk was full
  (void)night.run();
  EXPECT_EQ(night.calls(), 7u);
  night.options.again = true;
  (void)night.run();
  EXPECT_EQ(night.calls(), 11u);
}

TEST(batch, a_folder_without_recordings_is_named) {
  Night night;
  night.options.folder = night.root + "/in/notes";
  EXPECT_THROW((void)night.run(), InputError);
}

}  // namespace
}  // namespace pirvs::tools
