#include "bsp/linux/numbered_folder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace pirvs::bsp {
namespace {

namespace fs = std::filesystem;

class numbered_folder : public testing::Test {
 protected:
  numbered_folder() { fs::create_directories(folder_); }
  ~numbered_folder() override { fs::remove_all(folder_); }
  std::string next() {
    Text<16> name;
    EXPECT_EQ(make_numbered_folder(folder_.c_str(), name), Status::kOk);
    EXPECT_TRUE(fs::is_directory(folder_ / name.c_str())) << name.c_str();
    return name.c_str();
  }

  fs::path folder_ = fs::temp_directory_path() / ("pirvs_numbered_" + std::to_string(getpid()));
};

TEST_F(numbered_folder, goes_on_behind_the_highest_number) {
  EXPECT_EQ(next(), "0001");
  EXPECT_EQ(next(), "0002");
  fs::remove(folder_ / "0001");
  EXPECT_EQ(next(), "0003") << "a gap is left alone";
  fs::create_directory(folder_ / "0041");
  EXPECT_EQ(next(), "0042");
  fs::create_directory(folder_ / "9999");
  EXPECT_EQ(next(), "10000");
  EXPECT_EQ(next(), "10001");
}

TEST_F(numbered_folder, other_names_and_files_stay_as_they_are) {
  for (const char* name : {"map.bin", "17x", "-5", "99999999999999999999", "lost+found"}) {
    fs::create_directory(folder_ / name);
  }
  std::ofstream(folder_ / "0006") << "a file";
  EXPECT_EQ(next(), "0007");
  std::string content;
  std::ifstream(folder_ / "0006") >> content;
  EXPECT_EQ(content, "a");
}

TEST_F(numbered_folder, finds_the_highest_among_many) {
  constexpr int kMany = 200;  // more than one read of names
  for (int i = 1; i <= kMany; ++i) {
    fs::create_directory(folder_ / ("a name of some length " + std::to_string(i)));
  }
  fs::create_directory(folder_ / "0123");
  EXPECT_EQ(next(), "0124");
}

TEST_F(numbered_folder, says_why_there_is_none) {
  Text<16> name;
  EXPECT_EQ(make_numbered_folder((folder_ / "none").c_str(), name), Status::kNotFound);
  std::ofstream(folder_ / "file") << "no folder";
  EXPECT_EQ(make_numbered_folder((folder_ / "file").c_str(), name), Status::kNotFound);
  EXPECT_EQ(make_numbered_folder("/proc/self/fd", name), Status::kNotFound)
      << "nothing can be made there";
}

}  // namespace
}  // namespace pirvs::bsp
