// Board qemu-virt: the application without an operating system, against the host's; its faults.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/emulator/machine.h"
#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

constexpr int kSafeState = 3;

const std::string& five_seconds() {
  static const std::string pack = pack_of(5);
  return pack;
}

// Shared: five seconds on four cores.
const MachineRun& four_cores() {
  static const MachineRun run = run_machine("qemu-virt", five_seconds(), "");
  return run;
}

std::string line_of(const MachineRun& run, const std::string& begin) {
  const size_t at = run.console.find("\n" + begin);
  if (at == std::string::npos) return "no line '" + begin + "'";
  return run.console.substr(at + 1, run.console.find('\n', at + 1) - at - 1);
}

TEST(qemu_virt, four_cores_give_the_hosts_bytes) {
  const Replay host = replay(tools::open_recording(five_seconds(), {}));
  print("host", host);
  const MachineRun& run = four_cores();
  std::printf("%s\n", line_of(run, "run: ").c_str());
  EXPECT_EQ(run.status, 0) << run.console;
  EXPECT_GE(std::count(run.trajectory.begin(), run.trajectory.end(), '\n'), 70);
  EXPECT_TRUE(run.trajectory == host.trajectory()) << "another trajectory than the host's";
  EXPECT_TRUE(run.says("100 frames, ") || run.says("101 frames, ")) << run.console;
}

// Console (with its count of instructions), trajectory and times, to the byte.
TEST(qemu_virt, twice_the_same_bytes_and_instructions) {
  const MachineRun again = run_machine("qemu-virt", five_seconds(), "");
  EXPECT_EQ(line_of(again, "run: "), line_of(four_cores(), "run: "));
  EXPECT_TRUE(again.console == four_cores().console);
  EXPECT_TRUE(again.trajectory == four_cores().trajectory);
  EXPECT_TRUE(again.timing == four_cores().timing);
}

TEST(qemu_virt, one_core_gives_the_hosts_bytes) {
  const Replay host = replay(tools::open_recording(short_pack(), {}));
  const MachineRun run = run_machine("qemu-virt", short_pack(), "cores=1");
  EXPECT_EQ(run.status, 0) << run.console;
  EXPECT_TRUE(run.trajectory == host.trajectory()) << run.console;
  EXPECT_FALSE(run.trajectory.empty());
}

// Mapping may lag; what is asked is that it ends well, not when a snapshot arrives.
TEST(qemu_virt, runs_freely_on_four_cores) {
  const MachineRun run = run_machine("qemu-virt", short_pack(), "pace=free");
  EXPECT_EQ(run.status, 0) << run.console;
  EXPECT_TRUE(run.says("tracking at the end")) << run.console;
}

void expect_restart(const MachineRun& run, const std::string& report, const std::string& place) {
  EXPECT_EQ(run.status, kSafeState) << run.console;
  EXPECT_TRUE(run.says("*** fault: " + report)) << run.console;
  EXPECT_TRUE(run.says("called from, innermost first:")) << run.console;
  EXPECT_TRUE(run.says(place)) << run.console;
  EXPECT_TRUE(run.says("App::")) << "no caller by name:\n" << run.console;
  EXPECT_TRUE(run.says("*** restart 1 of qemu-virt, safe state: no task runs. Why:"))
      << run.console;
  // Said when it happened, and again by the restarted image.
  const size_t first = run.console.find("*** fault: " + report);
  EXPECT_NE(run.console.find("*** fault: " + report, first + 1), std::string::npos) << run.console;
}

TEST(qemu_virt_fault, a_null_access_is_reported_and_restarts_into_the_safe_state) {
  expect_restart(run_machine("qemu-virt", short_pack(), "fault=null fault_at=5"),
                 "null access: read at 0x0000000000000010, not mapped", "read_null");
}

TEST(qemu_virt_fault, a_stack_overflow_meets_the_guard) {
  expect_restart(run_machine("qemu-virt", short_pack(), "fault=stack fault_at=5"),
                 "stack overflow: core 0 has used its", "descend");
}

TEST(qemu_virt_fault, a_task_that_never_returns_is_found_by_the_watchdog) {
  expect_restart(run_machine("qemu-virt", short_pack(), "fault=hang fault_at=5"),
                 "watchdog: task door has not returned for 1.", "never_return");
}

TEST(qemu_virt_fault, a_bug_says_where_and_restarts) {
  expect_restart(run_machine("qemu-virt", short_pack(), "fault=assert fault_at=5"),
                 "bug: this_is_a_test is false, board/bare/fault_injection.cc:", "strike");
}

// Core 0 has to be stopped, and started again from the core that failed.
TEST(qemu_virt_fault, a_fault_on_another_core_restarts_core_0) {
  const MachineRun run =
      run_machine("qemu-virt", short_pack(), "cores=1 fault=null fault_at=5 fault_core=3");
  EXPECT_EQ(run.status, kSafeState) << run.console;
  EXPECT_TRUE(run.says("core 3, task none")) << run.console;
  EXPECT_TRUE(run.says("read_null")) << run.console;
  EXPECT_TRUE(run.says("*** restart 1 of qemu-virt, safe state")) << run.console;
}

TEST(qemu_virt_input, a_missing_or_damaged_recording_is_refused) {
  const MachineRun none = run_machine("qemu-virt", "", "");
  EXPECT_EQ(none.status, 2) << none.console;
  EXPECT_TRUE(none.says("not found")) << none.console;
  const std::string cut = scratch_folder("cut") + "/recording.pack";
  std::filesystem::copy_file(short_pack(), cut);
  std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
  const MachineRun damaged = run_machine("qemu-virt", cut, "");
  EXPECT_EQ(damaged.status, 2) << damaged.console;
  EXPECT_TRUE(damaged.says("bad data")) << damaged.console;
}

TEST(qemu_virt_input, words_that_make_no_sense_are_refused) {
  for (const char* words : {"fault=none_such", "cores=0", "cores=5", "cores=many"}) {
    EXPECT_EQ(run_machine("qemu-virt", short_pack(), words).status, 2) << words;
  }
}

}  // namespace
}  // namespace pirvs::systems
