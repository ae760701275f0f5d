// What a viewer costs the device it looks at: a replay in real time sends the device's stream by
// board/linux/stream_output.h, and `pirvs view` asks for it over loopback.
// In      PIRVS_BUILD (default build): host/pirvs and view/view.html. PIRVS_NIGHTLY.
// Cost    48 s, in real time.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "board/host/board.h"
#include "board/linux/stream_output.h"
#include "tests/recordings.h"
#include "tools/run/feed.h"
#include "tools/run/playback.h"
#include "tools/run/run_log.h"

namespace pirvs::systems {
namespace {

constexpr double kSeconds = 12;

// As board/linux/main.cc feeds the stream.
class Sender : public tools::RunListener {
 public:
  explicit Sender(const App& app) {
    const char* const why = stream_.open({}, app, [](board::VisitValue visit, void* context) {
      for (uint64_t i = 0; i < 300; ++i) {
        visit(context, ("a.counter_like_others_" + std::to_string(i)).c_str(), i);
      }
    });
    EXPECT_EQ(why, nullptr) << why;
  }
  ~Sender() override { stream_.close(); }
  int port() const { return stream_.port().value(); }
  uint64_t sent() const { return stream_.counters().sent; }
  void poll() { stream_.poll(); }

  void tracked(TimeNs, const StereoFrame& images, const Tracker&) override {
    stream_.frame(images);
  }
  void pose(const Pose& pose) override { stream_.pose(pose); }
  void health(TimeNs t, HealthState state, const char* what) override {
    stream_.health(t, state, what);
  }
  void fused(const FusedPose& pose) override { stream_.fused(pose); }
  void answer(const Answer&) override {}

 private:
  board::StreamOutput stream_;
};

pid_t start_viewer(int port) {
  const char* const build = std::getenv("PIRVS_BUILD");
  const std::string program = std::string(build != nullptr ? build : "build") + "/host/pirvs";
  const std::string source = "udp:127.0.0.1:" + std::to_string(port);
  const char* const words[] = {program.c_str(), "view", source.c_str(), "--port", "0", nullptr};
  pid_t pid = -1;
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  posix_spawn_file_actions_addopen(&quiet, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  EXPECT_EQ(posix_spawn(&pid, words[0], &quiet, nullptr, const_cast<char**>(words), environ), 0);
  posix_spawn_file_actions_destroy(&quiet);
  return pid;
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Load {
  double cpu = 0;  // 1: a core
  uint64_t sent = 0;
};

Load load_of(const tools::Recording& recording, bool viewed) {
  const auto app = std::make_unique<App>();
  tools::RunLog log(recording.frames.size());
  Sender sender(*app);
  log.listeners.push_back(&sender);
  tools::Feed feed(recording);
  app->configure(recording.calibration, AppParams{}, log.sinks());
  log.attach(*app, recording.imu.size());
  const pid_t viewer = viewed ? start_viewer(sender.port()) : -1;
  const double begin_s = cpu_seconds();
  const Status status =
      play(*app, feed.source(), board::kPlans[1], tools::Playback::kRealTime, [&] {
        log.take_poses(*app);
        sender.poll();
      });
  const Load out = {(cpu_seconds() - begin_s) / recording.duration_s(), sender.sent()};
  EXPECT_EQ(status, Status::kOk);
  if (viewer > 0) {
    kill(viewer, SIGKILL);
    waitpid(viewer, nullptr, 0);
  }
  return out;
}

TEST(view, a_viewer_costs_the_device_little) {
  if (std::getenv("PIRVS_NIGHTLY") == nullptr) GTEST_SKIP() << "for make nightly";
  tools::SimOptions options;
  options.duration_s = kSeconds;
  const tools::Recording recording = made(options, "view_load");
  // In turn, and the least of each: others use this machine, too.
  Load alone{1e9, 0}, viewed{1e9, 0};
  for (int i = 0; i < 2; ++i) {
    const Load a = load_of(recording, false), b = load_of(recording, true);
    if (a.cpu < alone.cpu) alone = a;
    if (b.cpu < viewed.cpu) viewed = b;
  }
  std::printf(
      "CPU alone %.2f %% of a core, with a viewer %.2f %%: +%.2f; %llu datagrams in %.0f s\n",
      100 * alone.cpu, 100 * viewed.cpu, 100 * (viewed.cpu - alone.cpu),
      static_cast<unsigned long long>(viewed.sent), kSeconds);
  EXPECT_EQ(alone.sent, 0u);
  EXPECT_GT(viewed.sent, 150 * kSeconds) << "the viewer got its poses";
  EXPECT_LT(viewed.cpu - alone.cpu, 0.05);
}

}  // namespace
}  // namespace pirvs::systems
