// The Linux backends against their contracts in bsp/api.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <string>

#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/storage.h"
#include "bsp/linux/storage.h"

namespace pirvs::bsp {
namespace {

TEST(LinuxClock, AdvancesAndCpuTimeStandsStillAtRest) {
  const TimeNs begin = now(), cpu_begin = cpu_time();
  for (int i = 0; i < 100; ++i) relax();
  const TimeNs elapsed = now() - begin;
  EXPECT_GE(elapsed, 100 * 20'000);
  EXPECT_LT(cpu_time() - cpu_begin, elapsed);
}

TEST(LinuxCores, RunOnceEachAndCanBeStartedAgain) {
  static std::atomic<int> runs{0};
  const auto entry = [](void* argument) { runs += *static_cast<int*>(argument); };
  int ten = 10;
  for (int round = 1; round <= 2; ++round) {
    for (int core = 1; core < kCoresMax; ++core) {
      EXPECT_EQ(start_core(core, entry, &ten), Status::kOk);
      EXPECT_EQ(start_core(core, entry, &ten), Status::kFull);
    }
    join_cores();
    EXPECT_EQ(runs, round * 10 * (kCoresMax - 1));
  }
  EXPECT_EQ(start_core(0, entry, &ten), Status::kNotFound);
  EXPECT_EQ(start_core(kCoresMax, entry, &ten), Status::kNotFound);
}

class LinuxStorage : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(mkdtemp(directory_), nullptr);
    set_storage_directory(directory_);
  }
  void TearDown() override {
    set_storage_directory(".");
    unlink((std::string(directory_) + "/log").c_str());
    rmdir(directory_);
  }
  char directory_[32] = "/tmp/pirvs_storage_XXXXXX";
};

TEST_F(LinuxStorage, WritesWhatItIsGivenAndEmptiesOnOpening) {
  for (const std::string text : {"a longer first text", "short"}) {
    const File file = storage_open("log").value();
    EXPECT_EQ(storage_write(file, text.data(), 2), Status::kOk);
    EXPECT_EQ(storage_write(file, text.data() + 2, text.size() - 2), Status::kOk);
    EXPECT_EQ(storage_close(file), Status::kOk);
    std::string read;
    std::getline(std::ifstream(std::string(directory_) + "/log"), read);
    EXPECT_EQ(read, text);
  }
}

TEST_F(LinuxStorage, ReportsAFullDisk) {
  set_storage_directory("/dev");
  const File file = storage_open("full").value();
  EXPECT_EQ(storage_write(file, "x", 1), Status::kFull);
  EXPECT_EQ(storage_close(file), Status::kOk);
}

TEST_F(LinuxStorage, MakesTheFoldersOfAName) {
  const File file = storage_open("a/b/c").value();
  EXPECT_EQ(storage_write(file, "x", 1), Status::kOk);
  EXPECT_EQ(storage_close(file), Status::kOk);
  std::string read;
  std::getline(std::ifstream(std::string(directory_) + "/a/b/c"), read);
  EXPECT_EQ(read, "x");
  for (const char* name : {"/a/b/c", "/a/b", "/a"}) {
    EXPECT_EQ(remove((std::string(directory_) + name).c_str()), 0);
  }
}

TEST_F(LinuxStorage, ReportsAFileWhereAFolderShouldBeAndTooManyFiles) {
  EXPECT_EQ(storage_close(storage_open("log").value()), Status::kOk);
  EXPECT_EQ(storage_open("log/deeper").status(), Status::kNotFound);
  File files[kFilesMax];
  for (File& file : files) file = storage_open("log").value();
  EXPECT_EQ(storage_open("log").status(), Status::kFull);
  for (const File& file : files) EXPECT_EQ(storage_close(file), Status::kOk);
  EXPECT_DEATH((void)storage_close(files[0]), "bug");
}

}  // namespace
}  // namespace pirvs::bsp
