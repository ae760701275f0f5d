// The profiler on board qemu-virt: its counts beside the machine's own, and twice the same.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/emulator/machine.h"
#include "tests/recordings.h"
#include "tools/dataset/pack_file.h"

namespace pirvs::systems {
namespace {

// Between two readings of the machine's counter and the marks inside of them.
constexpr int64_t kMarks_instructions = 200;

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// Rows of a csv by name of column.
std::vector<std::map<std::string, std::string>> table(const std::string& path) {
  std::vector<std::map<std::string, std::string>> out;
  std::vector<std::string> names;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') {
        quoted = !quoted;
      } else if (c == ',' && !quoted) {
        cells.emplace_back();
      } else {
        cells.back() += c;
      }
    }
    if (names.empty()) {
      names = cells;
      continue;
    }
    out.emplace_back();
    for (size_t i = 0; i < names.size() && i < cells.size(); ++i) out.back()[names[i]] = cells[i];
  }
  return out;
}

const std::string& short_pack() {
  static const std::string pack = [] {
    const std::string folder = scratch_folder("prof_pack");
    tools::RecordingOptions options;
    options.duration_s = 1.0;  // long enough to start
    const tools::Recording* const real = clip();
    const std::string source = real ? real->folder : simulated(SimulatedDevice::kEuroc).folder;
    tools::write_pack(tools::open_recording(source, options), folder + "/recording.pack",
                      [](size_t, size_t) {});
    return folder + "/recording.pack";
  }();
  return pack;
}

// Leaves the profile in the folder that it returns.
std::string profile(const std::string& name, const std::string& options, const std::string& words) {
  const char* const set = std::getenv("PIRVS_BUILD");
  const std::string build = set ? set : "build", image = build + "/qemu-virt/pirvs";
  const std::string out = scratch_folder(name);
  const std::string command =
      "tools/prof/profile --elf " + image + ".elf --plugin " + build + "/prof/plugin.so --out " +
      out + " " + options + " -- tools/emulator/run --image " + image + ".bin --out " + out +
      " --recording " + short_pack() + " --timeout " + std::to_string(kRun_s_max) +
      " '--extra=-plugin {plugin}' " + words + " > " + out + "/stdout.txt";
  EXPECT_EQ(std::system(command.c_str()), 0) << read(out + "/output.txt");  // NOLINT(cert-env33-c)
  return out;
}

TEST(prof, counts_what_the_machine_counts_and_twice_the_same) {
  const std::string first = profile("prof_bench", "--bench", "bench");
  const std::string second = profile("prof_bench_again", "--bench", "bench");
  const auto kernels = table(first + "/bench.csv");
  EXPECT_GE(kernels.size(), 10u);
  for (const auto& kernel : kernels) {
    const int64_t ours = std::stoll(kernel.at("instructions"));
    const int64_t machines = std::stoll(kernel.at("counted_by_the_program"));
    EXPECT_GE(machines, ours) << kernel.at("kernel");
    EXPECT_LE(machines, ours + kMarks_instructions) << kernel.at("kernel");
    EXPECT_GT(std::stod(kernel.at("a72_cycles")), 0.2 * static_cast<double>(ours));
    EXPECT_LT(std::stod(kernel.at("a72_cycles")), 5.0 * static_cast<double>(ours));
  }
  EXPECT_TRUE(read(first + "/counts.bin") == read(second + "/counts.bin"));
}

TEST(prof, functions_and_frames_sum_to_the_same) {
  const std::string out = profile("prof_run", "", "profile");
  int64_t by_function = 0, by_frame = 0;
  for (const auto& row : table(out + "/functions.csv")) {
    by_function += std::stoll(row.at("instructions"));
    EXPECT_NE(row.at("function"), "");
  }
  const auto frames = table(out + "/frames.csv");
  EXPECT_GE(frames.size(), 8u);
  for (const auto& row : frames) {
    for (const char* column : {"image", "matching", "tracking", "mapping", "outside"})
      by_frame += std::stoll(row.at(std::string(column) + "_instructions"));
    EXPECT_GT(std::stoll(row.at("image_instructions")), 1'000'000);
  }
  EXPECT_EQ(by_function, by_frame);
  const std::string text = read(out + "/profile.txt");
  for (const char* line : {"Image Processing", "Matching", "Tracking", "Mapping", "End-to-End",
                           "worst frame", "goal image processing", "ESTIMATED"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
  EXPECT_NE(read(out + "/prof.json").find("\"traceEvents\""), std::string::npos);
  EXPECT_NE(read(out + "/output.txt").find("profile: cycles counted by an emulator"),
            std::string::npos);
}

}  // namespace
}  // namespace pirvs::systems
