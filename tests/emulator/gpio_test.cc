// Pins of qemu-virt, driven from outside: edges are stamped by the interrupt handler, not by the
// one who looks for them later.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "tests/emulator/machine.h"

namespace pirvs::systems {
namespace {

struct Edge {
  std::string pin;
  int level;
  double t_s, polled_s;
};

std::vector<Edge> edges_of(const MachineRun& run) {
  std::vector<Edge> edges;
  std::istringstream lines(run.console);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    Edge edge;
    if (words >> word >> edge.pin >> edge.level >> edge.t_s >> edge.polled_s && word == "edge") {
      edges.push_back(edge);
    }
  }
  return edges;
}

TEST(qemu_virt_gpio, an_edge_is_stamped_in_the_handler_and_reported) {
  constexpr size_t kEdges = 12;
  // Far enough apart that a loaded host does not merge two; five are waiting when polled.
  constexpr double kEvery_s = 0.1, kPoll_s = 0.5;
  const MachineRun run =
      run_tool("tools/emulator/edges --image " + image_of("qemu-virt") +
               " --line 3 --every 0.1 --edges " + std::to_string(kEdges) + " watch_poll_ms=500");
  EXPECT_EQ(run.status, 0) << run.console;
  const std::vector<Edge> edges = edges_of(run);
  ASSERT_EQ(edges.size(), kEdges) << run.console;
  double waited_s_max = 0.0;
  for (size_t i = 0; i < kEdges; ++i) {
    EXPECT_EQ(edges[i].pin, "0.3");
    EXPECT_EQ(edges[i].level, i % 2 == 0 ? 1 : 0) << run.console;
    EXPECT_LE(edges[i].t_s, edges[i].polled_s);
    waited_s_max = std::max(waited_s_max, edges[i].polled_s - edges[i].t_s);
    if (i == 0) continue;
    // The host's clock; a loaded host may wait longer, never shorter.
    EXPECT_GT(edges[i].t_s - edges[i - 1].t_s, kEvery_s / 2) << run.console;
  }
  EXPECT_GT(edges.back().t_s - edges[0].t_s, kEvery_s * (kEdges - 2)) << run.console;
  EXPECT_GT(waited_s_max, kPoll_s / 4) << "stamps that follow the polling:\n" << run.console;
}

TEST(qemu_virt_gpio, a_pin_that_does_not_exist_is_refused) {
  const MachineRun run = run_machine("qemu-virt", "", "watch=0.8");
  EXPECT_EQ(run.status, 2) << run.console;
  EXPECT_TRUE(run.says("no such pin")) << run.console;
}

}  // namespace
}  // namespace pirvs::systems
