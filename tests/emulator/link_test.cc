// The robot's link of an image without an operating system, on its emulated UART.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "modules/link/mavlink_messages.h"
#include "tests/emulator/machine.h"
#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

using mavlink::Frame;

std::string content_of(const std::string& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

std::vector<Frame> frames_in(const std::string& bytes) {
  static mavlink::FrameParser parser;
  parser.clear();
  std::vector<Frame> out;
  const auto* at = reinterpret_cast<const uint8_t*>(bytes.data());
  for (size_t left = bytes.size(); left > 0;) {
    const size_t taken = parser.push(at, left);
    at += taken;
    left -= taken;
    for (Frame frame; parser.next(frame);) out.push_back(frame);
  }
  return out;
}

bool same(const Frame& a, const Frame& b) {
  return a.id == b.id && a.sequence == b.sequence && a.size == b.size &&
         std::equal(a.payload, a.payload + a.size, b.payload);
}

// Between the lines of its console.
TEST(emulated_link, the_uart_carries_the_hosts_frames) {
  const std::string log = scratch_folder("emulated_link") + "/host.tlog";
  const char* const build = std::getenv("PIRVS_BUILD");
  const MachineRun host =
      run_tool(std::string(build ? build : "build") + "/host/pirvs run " + short_pack() +
               " --out " + scratch_folder("emulated_link_run") + " --mavlink " + log);
  ASSERT_EQ(host.status, 0) << host.console;
  const MachineRun run = run_machine("qemu-virt", short_pack(), "cores=1 link");
  EXPECT_EQ(run.status, 0) << run.console;
  const std::vector<Frame> expected = frames_in(content_of(log)), heard = frames_in(run.line);
  int poses = 0;
  ASSERT_EQ(heard.size(), expected.size());
  for (size_t i = 0; i < heard.size(); ++i) {
    EXPECT_TRUE(same(heard[i], expected[i])) << i;
    mavlink::Odometry pose;
    poses += mavlink::decode(heard[i], pose);
  }
  std::printf("%zu frames, %d poses\n", heard.size(), poses);
  EXPECT_GT(poses, 20);
}

}  // namespace
}  // namespace pirvs::systems
