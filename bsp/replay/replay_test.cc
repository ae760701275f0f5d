#include "bsp/replay/replay.h"

#include <gtest/gtest.h>

#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/tick.h"

namespace pirvs::bsp {
namespace {

// IMU at 1 kHz and frames at 100 Hz, which start 3 ms later.
struct Script {
  static constexpr TimeNs kBegin = 1'000'000'000'000;
  int imu = 0, frames = 0, released = 0;
  TimeNs latency = 0;

  RecordingSource source() {
    return {this,
            [](void* context, ImuSample& out) {
              int& i = static_cast<Script*>(context)->imu;
              out.t = kBegin + i * 1'000'000;
              return i++ < 20;
            },
            [](void* context, StereoFrame& out) {
              int& i = static_cast<Script*>(context)->frames;
              out.t = kBegin + 3'000'000 + i * 10'000'000;
              return i++ < 2;
            },
            [](void* context, FrameId) { ++static_cast<Script*>(context)->released; },
            [](void* context, bool frame) {
              const Script& s = *static_cast<Script*>(context);
              if (!frame) return kBegin + (s.imu - 1) * 1'000'000;
              return kBegin + 3'000'000 + (s.frames - 1) * 10'000'000 + s.latency;
            }};
  }
};

TEST(Replay, FastGivesItemsInTheOrderOfTheirArrival) {
  for (const TimeNs latency : {0, 2'500'000}) {
    Replay replay;
    Script script;
    script.latency = latency;
    replay.start(script.source(), ReplayPace::kFast);
    TimeNs newest = 0;
    int samples = 0, frames = 0;
    for (bool ended = false; !ended;) {
      StereoFrame frame;
      ImuSample sample;
      if (replay.poll(frame) == Status::kOk) {
        EXPECT_EQ(frame.t, Script::kBegin + 3'000'000 + frames * 10'000'000);
        EXPECT_EQ(newest, frame.t + latency / 1'000'000 * 1'000'000);
        ++frames;
        replay.release(frame.id);
      }
      const Status status = replay.poll(sample);
      ended = status == Status::kStale;
      if (ended) break;
      ASSERT_EQ(status, Status::kOk);
      EXPECT_EQ(sample.t, Script::kBegin + samples++ * 1'000'000);
      newest = sample.t;
    }
    EXPECT_EQ(samples, 20);
    EXPECT_EQ(frames, 2);
    StereoFrame frame;
    EXPECT_EQ(replay.poll(frame), Status::kStale);
    EXPECT_EQ(replay.poll(frame), Status::kStale);
    EXPECT_EQ(script.released, 2);
    TimeNs tick;
    EXPECT_EQ(replay.poll_tick(tick), Status::kEmpty) << "it has no time of its own";
  }
}

TEST(Replay, FramesThatAreNotAskedForDoNotHoldUpTheImu) {
  Replay replay;
  Script script;
  replay.start(script.source(), ReplayPace::kFast);
  ImuSample sample;
  for (int i = 0; i < 20; ++i) ASSERT_EQ(replay.poll(sample), Status::kOk);
  EXPECT_EQ(replay.poll(sample), Status::kStale);
  StereoFrame frame;
  EXPECT_EQ(replay.poll(frame), Status::kOk);
}

TEST(Replay, RealTimeGivesNothingBeforeItsStamp) {
  Replay replay;
  Script script;
  replay.start(script.source(), ReplayPace::kRealTime);
  const TimeNs begin = now();
  bool imu_ended = false, frames_ended = false;
  int items = 0;
  while (!imu_ended || !frames_ended) {
    ImuSample sample;
    StereoFrame frame;
    const Status imu = replay.poll(sample);
    const Status camera = replay.poll(frame);
    const TimeNs elapsed = now() - begin;
    if (imu == Status::kOk) {
      EXPECT_GE(elapsed, sample.t - Script::kBegin);
    }
    if (camera == Status::kOk) {
      EXPECT_GE(elapsed, frame.t - Script::kBegin);
      replay.release(frame.id);
    }
    items += (imu == Status::kOk) + (camera == Status::kOk);
    imu_ended = imu == Status::kStale;
    frames_ended = camera == Status::kStale;
    relax();
  }
  EXPECT_EQ(items, 22);
  EXPECT_GE(now() - begin, 19'000'000);
}

// Frames without an end, each in the memory of its slot.
struct Endless {
  int filled[kReplayFrames] = {};
  int frames = 0, released = 0;

  RecordingSource source() {
    return {this, [](void*, ImuSample&) { return false; },
            [](void* context, StereoFrame& out) {
              auto& self = *static_cast<Endless*>(context);
              self.filled[out.id.slot] = self.frames;
              out.t = self.frames++;
              return true;
            },
            [](void* context, FrameId id) {
              auto& self = *static_cast<Endless*>(context);
              self.filled[id.slot] = -1;
              ++self.released;
            }};
  }
};

TEST(Replay, LendsSeveralFramesAndTakesThemBackInAnyOrder) {
  Endless endless;
  Replay replay;
  replay.start(endless.source(), ReplayPace::kFast);
  StereoFrame frames[kFramesLentMax], next;
  for (StereoFrame& frame : frames) ASSERT_EQ(replay.poll(frame), Status::kOk);
  EXPECT_EQ(replay.poll(next), Status::kOk) << "one more may be on its way";
  EXPECT_EQ(replay.poll(next), Status::kEmpty);
  replay.retain(frames[3].id);
  replay.release(frames[3].id);
  EXPECT_EQ(replay.poll(next), Status::kEmpty) << "somebody else still holds it";
  EXPECT_EQ(endless.filled[frames[3].id.slot], 3);
  replay.release(frames[3].id);
  EXPECT_EQ(endless.released, 1);
  ASSERT_EQ(replay.poll(next), Status::kOk);
  EXPECT_EQ(next.t, kFramesLentMax + 1) << "a replay loses none";
  for (int i = 0; i < kFramesLentMax; ++i) {
    if (i == 3) continue;
    EXPECT_EQ(endless.filled[frames[i].id.slot], i);
    replay.release(frames[i].id);
  }
}

TEST(Replay, StopsOnFramesThatAreNotHeld) {
  Endless endless;
  Replay replay;
  replay.start(endless.source(), ReplayPace::kFast);
  EXPECT_DEATH(replay.release(FrameId{}), "bug");
  StereoFrame frame;
  ASSERT_EQ(replay.poll(frame), Status::kOk);
  replay.release(frame.id);
  EXPECT_DEATH(replay.release(frame.id), "bug");
  EXPECT_DEATH(replay.retain(frame.id), "bug");
}

}  // namespace
}  // namespace pirvs::bsp
