// Fusion on an image without an operating system: fixes come out of the pack, and the pose on the
// Earth has the host's bytes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/emulator/machine.h"
#include "tests/recordings.h"
#include "tools/dataset/pack_file.h"

namespace pirvs::systems {
namespace {

// A short flight needs little to be aligned.
constexpr const char* kSooner[] = {"fusion.align_span_m", "0.5"};

// Six seconds of a flight with a receiver whose fixes are late.
std::string pack_with_fixes() {
  tools::SimOptions flight;
  flight.duration_s = 6;
  flight.blur = 1;
  flight.format = "jpg";
  flight.gnss.kind = "rtk";
  flight.gnss.antenna = {0.2, -0.1, 0.5};
  flight.gnss.latency_s = 0.15;
  const std::string path = scratch_folder("pack_with_fixes") + "/recording.pack";
  tools::write_pack(made(flight, "flight_with_fixes"), path, [](size_t, size_t) {});
  return path;
}

std::string content_of(const std::string& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

TEST(emulated_fusion, a_pack_with_fixes_gives_the_hosts_fused_bytes) {
  const std::string pack = pack_with_fixes(), out = scratch_folder("fused_host");
  const char* const build = std::getenv("PIRVS_BUILD");
  const MachineRun host =
      run_tool(std::string(build != nullptr ? build : "build") + "/host/pirvs run " + pack +
               " --out " + out + " --set " + kSooner[0] + "=" + kSooner[1]);
  ASSERT_EQ(host.status, 0) << host.console;
  const std::string expected = content_of(out + "/fused.tum");
  const MachineRun run = run_machine(
      "qemu-virt", pack, std::string("cores=1 profile ") + kSooner[0] + "=" + kSooner[1]);
  EXPECT_EQ(run.status, 0) << run.console;
  EXPECT_TRUE(run.says("counter fusion_aligned 1")) << run.console;
  const auto lines = std::count(run.fused.begin(), run.fused.end(), '\n');
  EXPECT_GT(lines, 100);
  EXPECT_TRUE(run.fused == expected) << "another pose on the Earth than the host's";
  const size_t at = run.console.find("profile task fusion");
  ASSERT_NE(at, std::string::npos) << run.console;
  std::printf("%d poses on the Earth; %s\n", int(lines),
              run.console.substr(at, run.console.find('\n', at) - at).c_str());
}

}  // namespace
}  // namespace pirvs::systems
