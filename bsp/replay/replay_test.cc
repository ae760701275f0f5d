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
            [](void* context) { ++static_cast<Script*>(context)->released; },
            [](void* context, bool frame) {
              const Script& s = *static_cast<Script*>(context);
              if (!frame) return kBegin + (s.imu - 1) * 1'000'000;
              return kBegin + 3'000'000 + (s.frames - 1) * 10'000'000 + s.latency;
            }};
  }
};

TEST(Replay, FastGivesItemsInTheOrderOfTheirArrival) {
  for (const TimeNs latency : {0, 2'500'000}) {
    Script script;
    script.latency = latency;
    replay_start(script.source(), ReplayPace::kFast);
    TimeNs newest = 0;
    int samples = 0, frames = 0;
    for (bool ended = false; !ended;) {
      StereoFrame frame;
      ImuSample sample;
      if (camera_poll(frame) == Status::kOk) {
        EXPECT_EQ(frame.t, Script::kBegin + 3'000'000 + frames * 10'000'000);
        EXPECT_EQ(newest, frame.t + latency / 1'000'000 * 1'000'000);
        EXPECT_EQ(script.frames, ++frames) << "no frame is fetched while one is lent";
        camera_release();
      }
      const Status status = imu_poll(sample);
      ended = status == Status::kStale;
      if (ended) break;
      ASSERT_EQ(status, Status::kOk);
      EXPECT_EQ(sample.t, Script::kBegin + samples++ * 1'000'000);
      newest = sample.t;
    }
    EXPECT_EQ(samples, 20);
    EXPECT_EQ(frames, 2);
    StereoFrame frame;
    EXPECT_EQ(camera_poll(frame), Status::kStale);
    EXPECT_EQ(camera_poll(frame), Status::kStale);
    EXPECT_EQ(script.released, 2);
    TimeNs tick;
    EXPECT_EQ(tick_poll(tick), Status::kEmpty) << "it has no time of its own";
  }
}

TEST(Replay, FramesThatAreNotAskedForDoNotHoldUpTheImu) {
  Script script;
  replay_start(script.source(), ReplayPace::kFast);
  ImuSample sample;
  for (int i = 0; i < 20; ++i) ASSERT_EQ(imu_poll(sample), Status::kOk);
  EXPECT_EQ(imu_poll(sample), Status::kStale);
  StereoFrame frame;
  EXPECT_EQ(camera_poll(frame), Status::kOk);
}

TEST(Replay, RealTimeGivesNothingBeforeItsStamp) {
  Script script;
  replay_start(script.source(), ReplayPace::kRealTime);
  const TimeNs begin = now();
  bool imu_ended = false, frames_ended = false;
  int items = 0;
  while (!imu_ended || !frames_ended) {
    ImuSample sample;
    StereoFrame frame;
    const Status imu = imu_poll(sample);
    const Status camera = camera_poll(frame);
    const TimeNs elapsed = now() - begin;
    if (imu == Status::kOk) {
      EXPECT_GE(elapsed, sample.t - Script::kBegin);
    }
    if (camera == Status::kOk) {
      EXPECT_GE(elapsed, frame.t - Script::kBegin);
      camera_release();
    }
    items += (imu == Status::kOk) + (camera == Status::kOk);
    imu_ended = imu == Status::kStale;
    frames_ended = camera == Status::kStale;
    relax();
  }
  EXPECT_EQ(items, 22);
  EXPECT_GE(now() - begin, 19'000'000);
}

TEST(Replay, StopsOnWrongUseOfFrames) {
  Script script;
  replay_start(script.source(), ReplayPace::kFast);
  StereoFrame frame;
  EXPECT_DEATH(camera_release(), "bug");
  ImuSample sample;
  while (camera_poll(frame) != Status::kOk) ASSERT_EQ(imu_poll(sample), Status::kOk);
  EXPECT_DEATH((void)camera_poll(frame), "bug");
}

}  // namespace
}  // namespace pirvs::bsp
