// One camera against a kernel of our own.
#include "bsp/linux/v4l2_node.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bsp/api/clock.h"
#include "bsp/linux/v4l2_fake_test.h"

namespace pirvs::bsp {
namespace {

class V4l2NodeTest : public testing::Test {
 protected:
  void SetUp() override { kernel = FakeKernel{}; }
  void start(const V4l2Setup& setup) {
    node_.configure(setup, kNews, kFake);
    V4l2Image image;
    ASSERT_EQ(node_.take(image), Status::kEmpty);
    begin_ = now();
  }
  FakeCamera& camera() { return kernel.cameras[0]; }
  // Shoots, and takes what comes of it.
  V4l2Image shot(const Shot& shot) {
    camera().shoot(shot);
    V4l2Image image;
    EXPECT_EQ(node_.take(image), Status::kOk);
    return image;
  }
  static TimeNs us(TimeNs t) { return t / 1000 * 1000; }  // what a v4l2_buffer carries

  V4l2Node node_;
  TimeNs begin_ = 0;
};

TEST_F(V4l2NodeTest, LendsTheCamerasOwnMemory) {
  start(setup_of(0));
  EXPECT_EQ(camera().queued.size(), size_t{V4l2Node::kBuffers});
  const V4l2Image image = shot({begin_, 7, 200});
  EXPECT_EQ(image.data, camera().memory[0].data()) << "no copy";
  EXPECT_EQ(image.stride, kWidth);
  EXPECT_EQ(image.sequence, 7u);
  EXPECT_EQ(image.t, us(begin_));
  EXPECT_EQ(camera().queued.size(), size_t{V4l2Node::kBuffers} - 1);
  node_.give_back(image.buffer);
  V4l2Image none;
  EXPECT_EQ(node_.take(none), Status::kEmpty);
  EXPECT_EQ(camera().queued.size(), size_t{V4l2Node::kBuffers}) << "queued again";
}

TEST_F(V4l2NodeTest, OtherFormatsBecomeGreyInMemoryOfOurOwn) {
  for (const uint32_t format :
       {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_UYVY, V4L2_PIX_FMT_Y10, V4L2_PIX_FMT_Y16}) {
    kernel = FakeKernel{};
    camera().format = format;
    camera().bytes_per_pixel = 2;
    V4l2Node node;
    node.configure(setup_of(0), kNews, kFake);
    V4l2Image images[2];
    ASSERT_EQ(node.take(images[0]), Status::kEmpty) << kernel.told.back();
    for (int i = 0; i < 2; ++i) {
      camera().shoot({now(), uint32_t(i), uint8_t(100 + i)});
      ASSERT_EQ(node.take(images[i]), Status::kOk);
    }
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(images[i].stride, kWidth);
      for (size_t k = 0; k < kBytes; ++k) ASSERT_EQ(images[i].data[k], 100 + i) << format;
      node.give_back(images[i].buffer);
    }
  }
}

TEST_F(V4l2NodeTest, EveryKindOfStampBecomesTheMiddleOfTheExposure) {
  V4l2Setup setup = setup_of(0);
  setup.exposure_ns = 4 * kMs;
  setup.readout_ns = 10 * kMs;
  start(setup);
  const TimeNs t = begin_ + 100 * kMs;
  constexpr uint32_t kEof = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  EXPECT_EQ(shot({t, 1}).t, us(t) + 2 * kMs) << "start of exposure";
  EXPECT_EQ(shot({t, 2, 0, kEof}).t, us(t) - 12 * kMs) << "end of frame";
  const TimeNs before = begin_ + 20 * kMs;  // exposed since the stream began
  while (now() < before) continue;
  const V4l2Image unknown = shot({0, 3, 0, V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN});
  EXPECT_GE(unknown.arrival, before);
  EXPECT_EQ(unknown.t, unknown.arrival - 12 * kMs);
  EXPECT_EQ(node_.counters().unstamped, 1u);
}

TEST_F(V4l2NodeTest, AFrameSyncOfTheSameSequenceIsBetterThanAStamp) {
  camera().has_frame_sync = true;
  camera().exposure = 60;  // 6 ms
  start(setup_of(0));
  const TimeNs t = begin_ + 20 * kMs;
  camera().frame_sync(t - 16 * kMs, 8);
  camera().frame_sync(t + 123, 9);
  EXPECT_EQ(shot({t + 9 * kMs, 9}).t, t + 123 - 3 * kMs) << "exposure ends as the frame begins";
  EXPECT_EQ(shot({t + 50 * kMs, 10}).t, us(t + 50 * kMs) + 3 * kMs) << "no event: the stamp";
  EXPECT_EQ(node_.counters().frame_sync_missed, 1u);
}

TEST_F(V4l2NodeTest, GapsErrorsAndStaleImagesAreCounted) {
  start(setup_of(0));
  const TimeNs t = begin_ + kMs;
  camera().shoot({begin_ - 3'600'000 * kMs, 0});  // left from an earlier stream
  camera().shoot({t, 1, 11});
  Shot bad = {t + 50 * kMs, 2};
  bad.flags |= V4L2_BUF_FLAG_ERROR;
  camera().shoot(bad);
  Shot cut = {t + 100 * kMs, 3};
  cut.cut = 1;
  camera().shoot(cut);
  camera().shoot({t + 300 * kMs, 7, 22});
  V4l2Image image;
  ASSERT_EQ(node_.take(image), Status::kOk);
  EXPECT_EQ(image.data[0], 11);
  ASSERT_EQ(node_.take(image), Status::kOk);
  EXPECT_EQ(image.data[0], 22);
  EXPECT_EQ(node_.counters().stale, 1u);
  EXPECT_EQ(node_.counters().damaged, 2u);
  EXPECT_EQ(node_.counters().lost, 3u);
  EXPECT_EQ(camera().queued.size(), size_t{V4l2Node::kBuffers} - 2) << "bad ones went back";
}

TEST_F(V4l2NodeTest, GoesAndComesBackWhileAnImageIsLent) {
  start(setup_of(0));
  const V4l2Image held = shot({begin_ + kMs, 1, 77});
  camera().plugged = false;
  V4l2Image image;
  EXPECT_EQ(node_.take(image), Status::kBusFault);
  EXPECT_EQ(node_.take(image), Status::kBusFault);
  EXPECT_FALSE(node_.is_open());
  EXPECT_EQ(held.data[0], 77) << "its memory stays";
  camera().plugged = true;
  const TimeNs begin = now();
  while (now() < begin + V4l2Node::kRetry_ns + 10 * kMs) {
    EXPECT_EQ(node_.take(image), Status::kBusFault) << "not while an image is out";
  }
  node_.give_back(held.buffer);
  EXPECT_EQ(node_.take(image), Status::kEmpty) << "streams again";
  EXPECT_EQ(node_.counters().unplugged, 1u);
  EXPECT_EQ(node_.counters().opened, 2u);
  const std::vector<std::string> kTold = {"/dev/video0: camera started",
                                          "/dev/video0: camera unplugged, waiting for it",
                                          "/dev/video0: camera started"};
  EXPECT_EQ(kernel.told, kTold);
}

TEST_F(V4l2NodeTest, SaysOnceWhyThereIsNoCamera) {
  struct Broken {
    const char* what;
    void (*breaks)(FakeCamera&);
  };
  const Broken kBroken[] = {
      {"no such camera, waiting for it", [](FakeCamera& c) { c.plugged = false; }},
      {"another program has the camera, waiting for it",
       [](FakeCamera& c) { c.open_error = EBUSY; }},
      {"no permission to use the camera", [](FakeCamera& c) { c.open_error = EACCES; }},
      {"the camera cannot give the calibration's size as grey or YUYV",
       [](FakeCamera& c) { c.format = V4L2_PIX_FMT_MJPEG; }},
      {"the camera has no memory", [](FakeCamera& c) { c.buffers_granted = 3; }},
  };
  for (const Broken& broken : kBroken) {
    kernel = FakeKernel{};
    broken.breaks(camera());
    V4l2Node node;
    node.configure(setup_of(0), kNews, kFake);
    V4l2Image image;
    EXPECT_EQ(node.take(image), Status::kBusFault);
    EXPECT_EQ(node.take(image), Status::kBusFault);
    ASSERT_EQ(kernel.told.size(), 1u);
    EXPECT_EQ(kernel.told[0], std::string("/dev/video0: ") + broken.what);
    EXPECT_FALSE(camera().streaming);
  }
}

}  // namespace
}  // namespace pirvs::bsp
