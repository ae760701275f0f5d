// The Linux backends against their contracts in bsp/api.
#include <gtest/gtest.h>
#include <sched.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/datagram.h"
#include "bsp/api/events.h"
#include "bsp/api/storage.h"
#include "bsp/linux/datagram.h"
#include "bsp/linux/events.h"
#include "bsp/linux/storage.h"
#include "core/sched/scheduler.h"

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

// A row that waits for a number to change, on a core of its own; counts how often it is asked.
struct Waiting {
  std::atomic<int> told{0};
  int seen = 0;
  std::atomic<int> asked{0};

  static Step step(void* context, TimeNs) {
    Waiting& self = *static_cast<Waiting*>(context);
    ++self.asked;
    const int now = self.told.load(std::memory_order_acquire);
    if (now == self.seen) return Step::kIdle;
    self.seen = now;
    return Step::kAgain;
  }
};

struct TwoCores {
  Waiting rows[2];
  const Task tasks[2] = {{"first", 0, 1'000, 0, 0, Waiting::step, &rows[0]},
                         {"second", 0, 1'000, 1, 0, Waiting::step, &rows[1]}};
  Scheduler scheduler{tasks, SchedulerHooks{now, wait, wake}};
  std::thread threads[2] = {std::thread([this] { scheduler.run(0); }),
                            std::thread([this] { scheduler.run(1); })};

  ~TwoCores() {
    scheduler.stop();
    for (std::thread& thread : threads) thread.join();
  }
};

TEST(LinuxEvents, ASchedulerAtRestWakesFewerThan50TimesASecond) {
  TwoCores cores;
  const TimeNs begin = now();
  timespec second{1, 0};
  nanosleep(&second, nullptr);
  const double seconds = to_seconds(now() - begin);
  for (const Waiting& row : cores.rows) {
    EXPECT_GE(row.asked, 2);
    EXPECT_LT(row.asked, 50 * seconds);
  }
}

TEST(LinuxEvents, AWakeIsNeverLost) {
  TwoCores cores;
  constexpr int kWakes = 2'000;
  const TimeNs begin = now();
  for (int i = 1; i <= kWakes; ++i) {
    cores.rows[1].told.store(i, std::memory_order_release);
    const int asked = cores.rows[1].asked;
    wake(1);
    while (cores.rows[1].asked == asked) sched_yield();
  }
  // Waiting out a rest each time would take 50 s.
  const double each_ms = 1e3 * to_seconds(now() - begin) / kWakes;
  std::printf("from wake to step: %.3f ms\n", each_ms);
  EXPECT_LT(to_seconds(now() - begin), 0.5 * kWakes * to_seconds(kRest_ns));
}

TEST(LinuxEvents, AWakeBeforeTheWaitCounts) {
  const TimeNs never = now() + 3'600'000'000'000;
  wake(3);
  wake(3);
  wait(3, never);
  const TimeNs begin = now();
  wait(3, begin + 20'000'000);
  EXPECT_GE(now() - begin, 20'000'000) << "both wakes were one";
}

TEST(LinuxEvents, AnAlarmEndsOneWait) {
  const TimeNs begin = now();
  alarm(begin + 30'000'000);
  alarm(begin + 10'000'000);
  wait(3, begin + 3'600'000'000'000);
  EXPECT_GE(now() - begin, 10'000'000);
  const TimeNs then = now();
  wait(3, then + 50'000'000);
  EXPECT_GE(now() - then, 50'000'000) << "the alarms are used up";
}

TEST(LinuxEvents, ADescriptorEndsTheWait) {
  int pipe_fds[2];
  ASSERT_EQ(pipe(pipe_fds), 0);
  ASSERT_EQ(watch_fd(3, pipe_fds[0]), Status::kOk);
  ASSERT_EQ(write(pipe_fds[1], "x", 1), 1);
  EXPECT_FALSE(take_ready(3, pipe_fds[0])) << "no wait has seen it";
  wait(3, now() + 3'600'000'000'000);
  EXPECT_TRUE(take_ready(3, pipe_fds[0]));
  EXPECT_FALSE(take_ready(3, pipe_fds[0])) << "once a wait";
  EXPECT_FALSE(take_ready(3, pipe_fds[1])) << "not watched";
  wait(3, now() + 3'600'000'000'000);
  forget_fd(3, pipe_fds[0]);
  EXPECT_FALSE(take_ready(3, pipe_fds[0]));
  const TimeNs begin = now();
  wait(3, begin + 5'000'000);
  EXPECT_GE(now() - begin, 5'000'000) << "no longer watched";
  for (int i = 0; i < kWaitFdsMax; ++i) EXPECT_EQ(watch_fd(3, pipe_fds[0]), Status::kOk);
  EXPECT_EQ(watch_fd(3, pipe_fds[0]), Status::kFull);
  forget_fd(3, pipe_fds[0]);
  for (const int fd : pipe_fds) close(fd);
}

TEST(LinuxDatagrams, ArriveWholeWithTheirSender) {
  const Socket a = datagram_open({}).value(), b = datagram_open({}).value();
  const Endpoint to_b = {Endpoint{}.address, datagram_port(b).value()};
  char text[32];
  size_t size = 0;
  Endpoint from;
  EXPECT_EQ(datagram_receive(b, text, sizeof text, size, from), Status::kEmpty);
  ASSERT_EQ(datagram_send(a, to_b, "pose 1", 6), Status::kOk);
  ASSERT_EQ(datagram_send(a, to_b, "pose 2, longer", 14), Status::kOk);
  wait(3, now() + 50'000'000);  // loopback: they are there
  ASSERT_EQ(datagram_receive(b, text, sizeof text, size, from), Status::kOk);
  EXPECT_EQ(std::string(text, size), "pose 1");
  EXPECT_EQ(from.port, datagram_port(a).value());
  EXPECT_EQ(from.address, Endpoint{}.address);
  EXPECT_EQ(datagram_receive(b, text, 6, size, from), Status::kBadData) << "its tail is lost";
  EXPECT_EQ(std::string(text, size), "pose 2");
  EXPECT_EQ(datagram_receive(b, text, sizeof text, size, from), Status::kEmpty);
  datagram_close(a);
  datagram_close(b);
}

TEST(LinuxDatagrams, EndTheWaitOfTheirReader) {
  const Socket a = datagram_open({}).value(), b = datagram_open({}).value();
  ASSERT_EQ(watch_fd(3, datagram_fd(b)), Status::kOk);
  ASSERT_EQ(datagram_send(a, {Endpoint{}.address, datagram_port(b).value()}, "x", 1), Status::kOk);
  wait(3, now() + 3'600'000'000'000);
  forget_fd(3, datagram_fd(b));
  datagram_close(a);
  datagram_close(b);
}

TEST(LinuxDatagrams, RefuseWhatCannotBe) {
  const Socket a = datagram_open({}).value();
  EXPECT_EQ(datagram_open({Endpoint{}.address, datagram_port(a).value()}).status(),
            Status::kBusFault)
      << "taken";
  static const char long_text[kDatagramMax + 1] = {};
  EXPECT_EQ(datagram_send(a, {}, long_text, sizeof long_text), Status::kBadData);
  Socket others[kSocketsMax - 1];
  for (Socket& other : others) other = datagram_open({}).value();
  EXPECT_EQ(datagram_open({}).status(), Status::kFull);
  for (const Socket& other : others) datagram_close(other);
  datagram_close(a);
  EXPECT_DEATH(datagram_close(a), "bug");
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

TEST_F(LinuxStorage, ReadsBackInPiecesUpToTheEnd) {
  const File out = storage_open("log").value();
  ASSERT_EQ(storage_write(out, "0123456789", 10), Status::kOk);
  ASSERT_EQ(storage_close(out), Status::kOk);
  const File in = storage_open_to_read("log").value();
  EXPECT_EQ(storage_size(in).value(), 10u);
  char text[8] = {};
  EXPECT_EQ(storage_read(in, text, 7).value(), 7u);
  EXPECT_EQ(std::string(text, 7), "0123456");
  EXPECT_EQ(storage_read(in, text, 7).value(), 3u) << "the end";
  EXPECT_EQ(std::string(text, 3), "789");
  EXPECT_EQ(storage_read(in, text, 7).value(), 0u);
  EXPECT_DEATH((void)storage_write(in, "x", 1), "bug");
  EXPECT_EQ(storage_close(in), Status::kOk);
  EXPECT_EQ(storage_open_to_read("none").status(), Status::kNotFound);
}

// The way to replace a file in one step: bsp/api/storage.h.
TEST_F(LinuxStorage, ReplacesAFileInOneStep) {
  const auto put = [](const char* name, const std::string& text) {
    const File file = storage_open(name).value();
    EXPECT_EQ(storage_write(file, text.data(), text.size()), Status::kOk);
    EXPECT_EQ(storage_sync(file), Status::kOk);
    EXPECT_EQ(storage_close(file), Status::kOk);
  };
  put("log", "old");
  put("log.new", "new and longer");
  const File reader = storage_open_to_read("log").value();
  EXPECT_EQ(storage_rename("log.new", "log"), Status::kOk);
  char text[32] = {};
  EXPECT_EQ(storage_read(reader, text, sizeof text).value(), 3u)
      << "an open file stays what it was";
  EXPECT_EQ(storage_close(reader), Status::kOk);
  const File again = storage_open_to_read("log").value();
  EXPECT_EQ(storage_read(again, text, sizeof text).value(), 14u);
  EXPECT_EQ(storage_close(again), Status::kOk);
  EXPECT_EQ(storage_rename("log.new", "log"), Status::kNotFound) << "the old name is gone";
  EXPECT_EQ(storage_remove("log"), Status::kOk);
  EXPECT_EQ(storage_remove("log"), Status::kNotFound);
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
