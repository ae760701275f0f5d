// Two cameras against a kernel of our own.
#include "bsp/linux/v4l2_stereo.h"

#include <gtest/gtest.h>

#include "bsp/api/clock.h"
#include "bsp/linux/v4l2_fake_test.h"

namespace pirvs::bsp {
namespace {

class V4l2StereoTest : public testing::Test {
 protected:
  void SetUp() override { kernel = FakeKernel{}; }
  void start(Pairing pairing = Pairing::kTrigger, int cameras = 2) {
    V4l2StereoSetup setup;
    for (int c = 0; c < 2; ++c) setup.camera[c] = setup_of(c);
    setup.cameras = cameras;
    setup.pairing = pairing;
    stereo_.configure(setup, kNews, kFake);
    StereoFrame frame;
    ASSERT_EQ(stereo_.poll(frame), Status::kEmpty);
    begin_ = now() / 1000 * 1000 + kMs;
  }
  // Trigger pulse k: cameras count from different numbers, the right one stamps 20 us later.
  void pulse(int k, uint8_t cameras = 3) {
    const TimeNs t = begin_ + k * 50 * kMs;
    const auto n = static_cast<uint32_t>(k);
    const auto grey = static_cast<uint8_t>(k);
    if ((cameras & 1) != 0) kernel.cameras[0].shoot({t, n + 4, grey});
    if ((cameras & 2) != 0) kernel.cameras[1].shoot({t + 20'000, n, grey});
  }
  // The next frame, given back at once: which pulse, and its images.
  struct Got {
    int pulse = -1;
    uint8_t present = 0;
    uint32_t lost_before = 0;
    StereoFrame frame;
  };
  Got next(TimeNs wait = 0) {
    Got got;
    const TimeNs until = now() + wait;
    Status status = Status::kEmpty;
    do {
      status = stereo_.poll(got.frame);
    } while (status == Status::kEmpty && now() < until);
    if (status != Status::kOk) return got;
    got.present = got.frame.present;
    got.lost_before = got.frame.lost_before;
    for (int c = 0; c < 2; ++c) {
      if ((got.present >> c & 1) == 0) continue;
      const int grey = got.frame.image[c].row(0)[0];
      EXPECT_TRUE(got.pulse < 0 || got.pulse == grey) << "images of different pulses are no pair";
      got.pulse = grey;
    }
    stereo_.release(got.frame.id);
    return got;
  }

  V4l2Stereo stereo_;
  TimeNs begin_ = 0;
};

TEST_F(V4l2StereoTest, PairsByTheTriggersCount) {
  start();
  for (int k = 0; k < 100; ++k) {
    pulse(k);
    const Got got = next();
    EXPECT_EQ(got.pulse, k);
    EXPECT_EQ(got.present, 3);
    EXPECT_EQ(got.lost_before, 0u);
    EXPECT_EQ(got.frame.t, begin_ + k * 50 * kMs);
    EXPECT_EQ(got.frame.late[1], 0);
    EXPECT_EQ(got.frame.info[1].sequence, uint32_t(k));
  }
  EXPECT_EQ(stereo_.counters().pairs, 100u);
  EXPECT_EQ(stereo_.counters().counts_found, 1u);
  EXPECT_EQ(kernel.cameras[0].without_buffer, 0u);
}

TEST_F(V4l2StereoTest, AStaleImageAtTheStartShiftsNoPair) {
  start();
  begin_ += 100 * kMs;
  kernel.cameras[1].shoot({begin_ - 300 * kMs, UINT32_MAX - 1, 99});  // of before the stream
  kernel.cameras[1].shoot({begin_ - 80 * kMs, UINT32_MAX, 98});       // nothing says it is stale
  for (int k = 0; k < 5; ++k) pulse(k);
  const Got stale = next();
  EXPECT_EQ(stale.pulse, 98);
  EXPECT_EQ(stale.present, 2) << "alone";
  for (int k = 0; k < 5; ++k) {
    const Got got = next();
    EXPECT_EQ(got.pulse, k);
    EXPECT_EQ(got.present, 3);
  }
  EXPECT_EQ(stereo_.node(1).counters().stale, 1u);
}

TEST_F(V4l2StereoTest, HalfAPairGoesOutAloneAndTheNextIsWhole) {
  start();
  pulse(0);
  EXPECT_EQ(next().present, 3);
  pulse(1, 1);
  pulse(2);
  const Got half = next();
  EXPECT_EQ(half.pulse, 1);
  EXPECT_EQ(half.present, 1);
  EXPECT_EQ(half.frame.image[1].data, nullptr);
  EXPECT_EQ(next().present, 3);
  pulse(3, 2);
  EXPECT_EQ(next().present, 0) << "its partner may still come";
  EXPECT_EQ(next(40 * kMs).present, 2) << "it did not";
  kernel.cameras[0].shoot({begin_ + 150 * kMs, 7, 3});
  EXPECT_EQ(next().present, 0) << "too late: its half has gone";
  EXPECT_EQ(stereo_.counters().after_its_half, 1u);
  pulse(6);
  const Got got = next();
  EXPECT_EQ(got.pulse, 6);
  EXPECT_EQ(got.lost_before, 2u);
  EXPECT_EQ(stereo_.counters().halves, 2u);
}

TEST_F(V4l2StereoTest, CountsThatSlipAreFoundAnew) {
  start();
  pulse(0);
  EXPECT_EQ(next().present, 3);
  // The right camera counts one pulse twice: its count no longer says which pulse it was.
  for (int k = 1; k < 4; ++k) {
    kernel.cameras[0].shoot({begin_ + k * 50 * kMs, uint32_t(k + 4), uint8_t(k)});
    kernel.cameras[1].shoot({begin_ + k * 50 * kMs, uint32_t(k + 1), uint8_t(k)});
    EXPECT_EQ(next().pulse, k);
  }
  EXPECT_EQ(stereo_.counters().counts_wrong, 1u);
  EXPECT_EQ(stereo_.counters().counts_found, 2u);
  EXPECT_EQ(stereo_.counters().pairs, 4u);
}

TEST_F(V4l2StereoTest, OneCameraUnpluggedLeavesTheOther) {
  start();
  pulse(0);
  EXPECT_EQ(next().present, 3);
  kernel.cameras[1].plugged = false;
  for (int k = 1; k < 4; ++k) {
    pulse(k, 1);
    EXPECT_EQ(next().present, 1);
  }
  kernel.cameras[1].plugged = true;
  const TimeNs begin = now();
  while (!stereo_.node(1).is_open() && now() < begin + 10 * V4l2Node::kRetry_ns) next();
  EXPECT_GE(now() - begin, V4l2Node::kRetry_ns * 9 / 10);
  begin_ = now() / 1000 * 1000;
  pulse(9);
  EXPECT_EQ(next().present, 3) << "the counts of the new stream are found";
  kernel.cameras[0].plugged = kernel.cameras[1].plugged = false;
  StereoFrame frame;
  EXPECT_EQ(stereo_.poll(frame), Status::kBusFault) << "no camera is left";
}

TEST_F(V4l2StereoTest, HeldFramesStayAndWhatComesMeanwhileIsLost) {
  start();
  StereoFrame held[kFramesLentMax];
  for (int k = 0; k < 30; ++k) {
    pulse(k);
    StereoFrame frame;
    const Status status = stereo_.poll(frame);
    EXPECT_EQ(status, k < kFramesLentMax ? Status::kOk : Status::kEmpty);
    if (status == Status::kOk) held[k] = frame;
  }
  for (int k = 0; k < kFramesLentMax; ++k) {
    EXPECT_EQ(held[k].image[0].row(0)[0], k) << "not overwritten while held";
    stereo_.release(held[k].id);
  }
  uint32_t lost = 0;
  int last = 0;
  for (int k = 30; k < 60; ++k) {
    pulse(k);
    const Got got = next();
    lost += got.lost_before;
    last = got.pulse;
  }
  EXPECT_GE(kernel.cameras[0].without_buffer, 16u);
  EXPECT_EQ(lost, kernel.cameras[0].without_buffer) << "each loss is told";
  EXPECT_GE(last, 50);
}

TEST_F(V4l2StereoTest, FreeRunningCamerasArePairedByStampAndSayHowLate) {
  start(Pairing::kStamp);
  kernel.cameras[0].shoot({begin_, 0, 1});
  kernel.cameras[1].shoot({begin_ + 12 * kMs, 0, 1});
  const Got got = next();
  EXPECT_EQ(got.present, 3);
  EXPECT_EQ(got.frame.t, begin_ + 12 * kMs);
  EXPECT_EQ(got.frame.late[0], 12 * kMs);
  EXPECT_EQ(got.frame.late[1], 0);
  kernel.cameras[0].shoot({begin_ + 50 * kMs, 1, 2});
  kernel.cameras[1].shoot({begin_ + 112 * kMs, 2, 3});
  EXPECT_EQ(next().present, 1) << "half a period apart is no pair";
}

TEST_F(V4l2StereoTest, BothCamerasAreToldTheSameWithinWhatBothCan) {
  kernel.cameras[0].has_exposure(60);
  kernel.cameras[0].controls[V4L2_CID_ANALOGUE_GAIN] = {16, 160, 16};
  kernel.cameras[1].has_exposure(10);
  kernel.cameras[1].controls[V4L2_CID_EXPOSURE_ABSOLUTE].max = 100;
  kernel.cameras[1].controls[V4L2_CID_ANALOGUE_GAIN] = {32, 128, 32};
  EXPECT_EQ(stereo_.range().status(), Status::kEmpty) << "there is no camera yet";
  start();
  ASSERT_TRUE(stereo_.range().ok());
  EXPECT_EQ(stereo_.range().value().exposure_ns_max, 10 * kMs);
  EXPECT_EQ(stereo_.range().value().gain_max, 4);
  EXPECT_EQ(stereo_.control({9 * kMs, 2}), Status::kOk);
  for (FakeCamera& camera : kernel.cameras) {
    EXPECT_EQ(camera.controls[V4L2_CID_EXPOSURE_ABSOLUTE].now, 90);
  }
  EXPECT_EQ(kernel.cameras[0].controls[V4L2_CID_ANALOGUE_GAIN].now, 32);
  EXPECT_EQ(kernel.cameras[1].controls[V4L2_CID_ANALOGUE_GAIN].now, 64);
  EXPECT_EQ(stereo_.control({11 * kMs, 2}), Status::kBadData);
  EXPECT_EQ(stereo_.control({9 * kMs, 5}), Status::kBadData);
}

TEST_F(V4l2StereoTest, ACameraWithoutControlsKeepsBothFromBeingTold) {
  kernel.cameras[0].has_exposure(60);
  start();
  EXPECT_EQ(stereo_.range().status(), Status::kNotFound);
  EXPECT_EQ(stereo_.control({9 * kMs, 1}), Status::kNotFound);
  EXPECT_EQ(kernel.cameras[0].times_set, 0);
}

TEST_F(V4l2StereoTest, OneCameraAloneIsAFrameOfItsOwn) {
  start(Pairing::kTrigger, 1);
  pulse(0, 1);
  EXPECT_EQ(next().present, 1);
  pulse(5, 1);
  EXPECT_EQ(next().lost_before, 4u);
}

}  // namespace
}  // namespace pirvs::bsp
