// Memory: no heap call while the stack runs, and pools within the device's share.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <new>
#include <optional>
#include <vector>

#include "board/host/board.h"
#include "bsp/replay/replay.h"
#include "tests/heap_guard.h"
#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/dataset/player.h"
#include "tools/run/playback.h"

namespace pirvs::systems {
namespace {

// All of a recording in memory, so that the sensors, too, ask for nothing while the stack runs.
class Preloaded {
 public:
  explicit Preloaded(const tools::Recording& recording) : recording_(recording) {
    tools::Player player(recording);
    while (const StereoFrame* const frame = player.next()) {
      frames_.push_back(*frame);
      for (ImageView& image : frames_.back().image) {
        pixels_.emplace_back(image.data, image.data + image.height * image.stride);
        image.data = pixels_.back().data();
      }
      player.release(frame);
    }
  }
  void rewind() { frame_at_ = imu_at_ = 0; }

  bsp::RecordingSource source() {
    return {this, next_imu, next_frame, [](void*, FrameId) {}};
  }
  // Counts heap calls from the first item on: by then other cores have been started.
  void arm_on_first(std::optional<HeapGuard>* guard) { guard_ = guard; }

 private:
  void arm() {
    if (guard_ != nullptr && !guard_->has_value()) guard_->emplace();
  }
  static bool next_imu(void* context, ImuSample& out) {
    auto& self = *static_cast<Preloaded*>(context);
    self.arm();
    if (self.imu_at_ == self.recording_.imu.size()) return false;
    out = self.recording_.imu[self.imu_at_++];
    return true;
  }
  static bool next_frame(void* context, StereoFrame& out) {
    auto& self = *static_cast<Preloaded*>(context);
    self.arm();
    if (self.frame_at_ == self.frames_.size()) return false;
    out = self.frames_[self.frame_at_++];
    return true;
  }

  const tools::Recording& recording_;
  std::vector<StereoFrame> frames_;
  std::vector<std::vector<uint8_t>> pixels_;
  size_t imu_at_ = 0, frame_at_ = 0;
  std::optional<HeapGuard>* guard_ = nullptr;
};

App app;

struct Sink {
  int frames = 0, poses = 0, keyframes_out = 0, health = 0;
  int consumer = -1;  // of the app's poses
  int allocate_at_frame = -1;
  void* volatile block = nullptr;
};

AppSinks sinks_of(Sink& sink) {
  AppSinks sinks;
  sinks.context = &sink;
  sinks.frame = [](void* context, const FrameReport&) {
    Sink& self = *static_cast<Sink*>(context);
    while (app.poses().next(self.consumer) != nullptr) ++self.poses;
    if (self.frames++ == self.allocate_at_frame) self.block = ::operator new(1);
  };
  sinks.health = [](void* context, TimeNs, HealthState, const char*) {
    ++static_cast<Sink*>(context)->health;
  };
  return sinks;
}

// Heap calls from App::run to its end.
size_t heap_calls(int cores, Sink& sink) {
  static Preloaded recording(simulated(SimulatedDevice::kEuroc));
  recording.rewind();
  app.configure(simulated(SimulatedDevice::kEuroc).calibration, AppParams{}, sinks_of(sink));
  sink.consumer = app.poses().attach().value();
  alarm(kReplay_s_max);
  std::optional<HeapGuard> guard;
  if (cores == 1) guard.emplace();
  recording.arm_on_first(&guard);
  const Status status =
      tools::play(app, recording.source(), board::kPlans[cores - 1], tools::Playback::kFast);
  guard.reset();
  alarm(0);
  EXPECT_EQ(status, Status::kOk);
  return HeapGuard::calls();
}

TEST(memory, no_heap_call_while_one_core_runs) {
  Sink sink;
  EXPECT_EQ(heap_calls(1, sink), 0u);
  if (HeapGuard::calls() > 0) HeapGuard::print_first();
  EXPECT_GT(sink.poses, 500);
}

TEST(memory, no_heap_call_once_two_cores_run) {
  Sink sink;
  EXPECT_EQ(heap_calls(2, sink), 0u);
  if (HeapGuard::calls() > 0) HeapGuard::print_first();
  EXPECT_GT(sink.poses, 500);
}

TEST(memory, the_guard_sees_a_single_call) {
  Sink sink;
  sink.allocate_at_frame = 60;
  EXPECT_EQ(heap_calls(1, sink), 1u);
  ::operator delete(sink.block);
  void* volatile block = nullptr;
  {
    const HeapGuard guard;
    block = std::malloc(10);
    block = std::realloc(block, 1000);
    std::free(block);
    block = std::calloc(1, 10);
    std::free(block);
    block = ::operator new (64, std::align_val_t{64});
  }
  ::operator delete (block, std::align_val_t{64});
  EXPECT_EQ(HeapGuard::calls(), 4u);
}

TEST(memory, pools_fit_the_share_of_this_board) {
  NamedValue pools[64];
  const int count = App::pools(pools, 64);
  size_t sum = 0;
  for (int i = 0; i < count; ++i) {
    std::printf("%-16s %10.3f MB\n", pools[i].name, double(pools[i].value) * 0x1p-20);
    sum += pools[i].value;
  }
  std::printf("%-16s %10.3f MB of %zu\n", "sum", double(sum) * 0x1p-20,
              size_t{kPoolBytesMax} >> 20);
  EXPECT_LE(sum, size_t{kPoolBytesMax});
  EXPECT_GE(sum, sizeof(App));
}

}  // namespace
}  // namespace pirvs::systems
