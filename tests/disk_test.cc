// `pirvs run` and the disk: bad input and bad output end in exit status 2 and one line, with
// nothing half-written; the recording of a run gives the run again.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "tests/recordings.h"
#include "tools/cli/command.h"
#include "tools/dataset/input_error.h"

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;

const std::string& sequence() { return simulated(SimulatedDevice::kEuroc).folder; }

// `pirvs run` as the command line calls it; an InputError is its exit status 2.
int run_command(const std::string& sequence, const std::string& out,
                const std::vector<std::string>& more = {}) {
  CLI::App options;
  const std::function<int()> run = tools::kRunCommand.declare(options);
  std::vector<std::string> arguments = {"--out", out, sequence};
  arguments.insert(arguments.end(), more.begin(), more.end());
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  options.parse(arguments);
  return run();
}

const std::vector<std::string> kShort = {"--duration", "1.5"};

std::string error_of(const std::string& sequence, const std::string& out,
                     const std::vector<std::string>& more = kShort) {
  try {
    return "exit status " + std::to_string(run_command(sequence, out, more));
  } catch (const tools::InputError& error) {
    return error.what();
  }
}

std::string content(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

size_t files_in(const std::string& folder) {
  return size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator{}));
}

// A copy of the recording whose files may be replaced, but not written over: they are shared.
std::string copy_of_recording(const std::string& name) {
  const std::string folder = scratch_folder(name);
  fs::copy(sequence(), folder,
           fs::copy_options::recursive | fs::copy_options::create_hard_links |
               fs::copy_options::overwrite_existing);
  return folder;
}

void replace(const std::string& path, const std::string& text) {
  fs::remove(path);
  std::ofstream(path, std::ios::binary) << text;
}

TEST(disk, when_it_is_full_one_line_says_so_and_nothing_is_half_written) {
  for (const char* file : {"trajectory.tum", "timing.csv", "summary.json", "report.html"}) {
    const std::string out = scratch_folder("full");
    replace(out + "/trajectory.tum", "of an earlier run");
    fs::create_symlink("/dev/full", out + "/" + file + ".part");
    const std::string error = error_of(sequence(), out);
    EXPECT_NE(error.find(file), std::string::npos) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    EXPECT_EQ(files_in(out), 1u) << "only what was there before";
    EXPECT_EQ(content(out + "/trajectory.tum"), "of an earlier run");
  }
}

TEST(disk, results_of_an_earlier_run_are_kept_unless_forced) {
  const std::string out = scratch_folder("earlier");
  replace(out + "/summary.json", "of an earlier run");
  EXPECT_NE(error_of(sequence(), out).find("--force"), std::string::npos);
  EXPECT_EQ(content(out + "/summary.json"), "of an earlier run");
  (void)run_command(sequence(), out, {"--duration", "1.5", "--force"});
  EXPECT_NE(content(out + "/summary.json"), "of an earlier run");
}

// As by Ctrl-C: what was run is written, a recording made of it is whole.
TEST(disk, a_run_that_is_stopped_writes_what_it_has) {
  const std::string out = scratch_folder("stopped"), record = scratch_folder("stopped_record");
  std::thread by_hand([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    std::raise(SIGINT);
  });
  const int status = run_command(sequence(), out, {"--realtime", "--record", record});
  by_hand.join();
  std::signal(SIGINT, SIG_DFL);
  EXPECT_EQ(status, 128 + SIGINT);
  for (const char* file : {"trajectory.tum", "state.csv", "summary.json", "report.html"}) {
    EXPECT_TRUE(fs::exists(out + "/" + file)) << file;
  }
  const tools::Recording whole = tools::open_recording(record, {});
  EXPECT_GT(whole.frames.size(), 10u);
  EXPECT_LT(whole.duration_s(), 5);
}

TEST(disk, where_nothing_can_be_written_the_run_does_not_begin) {
  const std::string folder = scratch_folder("unwritable");
  replace(folder + "/file", "");
  for (const std::string& out :
       {folder + "/file", folder + "/file/below", std::string("/proc/x")}) {
    const std::string error = error_of(sequence(), out);
    EXPECT_NE(error.find(out), std::string::npos) << error;
    EXPECT_NE(error.find("--out"), std::string::npos) << error;
  }
  fs::create_symlink("/dev/full", folder + "/probe.part");
  EXPECT_NE(error_of(sequence(), folder).find("check space"), std::string::npos);
  const std::string out = scratch_folder("out");
  EXPECT_NE(error_of(sequence(), out, {"--record", folder}).find("--record"), std::string::npos);
  EXPECT_EQ(files_in(out), 0u);
}

TEST(disk, what_is_missing_or_empty_is_named) {
  const std::string out = scratch_folder("out");
  for (const char* file : {"cam0/data.csv", "cam1/data.csv", "imu0/data.csv", "cam0/sensor.yaml",
                           "cam1/sensor.yaml", "imu0/sensor.yaml"}) {
    const std::string folder = copy_of_recording("missing");
    fs::remove(folder + "/mav0/" + file);
    const bool images = std::string(file).rfind("cam", 0) == 0 && std::string(file)[5] == 'd';
    if (!images) {  // whose names are stamps: a list is not needed
      EXPECT_NE(error_of(folder, out).find(file), std::string::npos) << error_of(folder, out);
    }
    replace(folder + "/mav0/" + file, "#timestamp [ns]\n");
    EXPECT_NE(error_of(folder, out).find(file), std::string::npos) << error_of(folder, out);
  }
  EXPECT_NE(error_of(scratch_folder("missing"), out).find("cam0"), std::string::npos);
  EXPECT_EQ(files_in(out), 0u) << "nothing is left of a run that was refused";
}

TEST(disk, tables_cut_off_in_a_row_are_read_up_to_there) {
  const std::string folder = copy_of_recording("cut_off");
  for (const char* file :
       {"imu0/data.csv", "cam1/data.csv", "state_groundtruth_estimate0/data.csv"}) {
    const std::string path = folder + "/mav0/" + file;
    const std::string whole = content(path);
    replace(path, whole.substr(0, whole.find(',', whole.size() / 2)));
  }
  const std::string out = scratch_folder("out");
  EXPECT_EQ(error_of(folder, out), "exit status 0");
  const auto summary = nlohmann::json::parse(content(out + "/summary.json"));
  EXPECT_EQ(summary["input_rejected"]["imu_rows_truncated"], 1);
  EXPECT_EQ(summary["input_rejected"]["image_rows_truncated"], 1);
  EXPECT_EQ(summary["input_rejected"]["truth_rows_truncated"], 1);
}

// The same bytes from the recording of a run as from the run, faults and all.
void expect_recorded_run_replays_to_the_byte(const std::string& sequence) {
  const std::vector<std::vector<std::string>> runs = {
      {},
      {"--fault", "nan:1", "--fault", "spike:1.2", "--fault", "late:1.5", "--fault", "stamp:1.7",
       "--fault", "clock-imu:2x0.3"}};
  for (const auto& faults : runs) {
    const std::string out = scratch_folder("live"), again = scratch_folder("again");
    const std::string record = scratch_folder("record");
    std::vector<std::string> more = {"--duration", "3", "--record", record};
    more.insert(more.end(), faults.begin(), faults.end());
    ASSERT_EQ(run_command(sequence, out, more), 0);
    ASSERT_EQ(run_command(record, again), 0);
    EXPECT_GT(content(out + "/trajectory.tum").size(), 1000u);
    for (const char* file : {"/trajectory.tum", "/state.csv", "/keyframes.tum", "/map.ply"}) {
      EXPECT_TRUE(content(out + file) == content(again + file)) << file;
    }
    const auto counters = nlohmann::json::parse(content(out + "/summary.json"))["counters"];
    EXPECT_GE(counters["frames_recorded"], 60);
    for (const char* loss : {"record_imu_dropped", "record_frame_dropped", "record_not_written"}) {
      EXPECT_EQ(counters[loss], 0) << loss;
    }
  }
}

TEST(disk, a_recorded_run_replays_to_the_byte) {
  expect_recorded_run_replays_to_the_byte(sequence());
}

TEST(disk, a_recorded_run_of_real_sensors_replays_to_the_byte) {
  if (clip() == nullptr) GTEST_SKIP() << "the real recording is not on this machine";
  expect_recorded_run_replays_to_the_byte(clip()->folder);
}

// Files above a size cannot grow: what a full disk or a quota answers.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    (void)std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(disk, a_recording_that_fills_it_stops_and_the_run_goes_on) {
  tools::SimOptions large;
  large.device = "oakd";
  large.duration_s = 1.6;
  large.rate_hz = 20;
  large.blur = 1;
  large.format = "pgm";
  const std::string sequence = made(large, "large").folder;
  const std::string out = scratch_folder("out"), record = scratch_folder("record");
  const std::vector<std::string> more = {"--duration", "1.5", "--record", record};
  std::string said;
  {
    const FileSizeLimit limit(1'000'000);  // less than an image, more than a report with its page
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_command(sequence, out, more), 0);
    said = testing::internal::GetCapturedStderr();
  }
  EXPECT_NE(said.find("recording stopped"), std::string::npos) << said;
  EXPECT_EQ(said.find("recording stopped"), said.rfind("recording stopped")) << "once";
  const auto summary = nlohmann::json::parse(content(out + "/summary.json"));
  EXPECT_GT(summary["counters"]["record_not_written"], 100);
  EXPECT_EQ(summary["frames"]["tracked"],
            summary["frames"]["in"].get<int>() - summary["frames"]["before_start"].get<int>());
  const std::string listed = content(record + "/mav0/cam0/data.csv");
  EXPECT_EQ(listed.find(".pgm"), std::string::npos) << "no image is listed that is not whole";
}

}  // namespace
}  // namespace pirvs::systems
