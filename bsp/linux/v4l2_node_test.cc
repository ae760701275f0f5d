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
  EXPECT_EQ(node_.counters().converted, 0u);
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
       {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_UYVY, V4L2_PIX_FMT_Y10, V4L2_PIX_FMT_Y16, V4L2_PIX_FMT_NV12,
        V4L2_PIX_FMT_SGBRG8, V4L2_PIX_FMT_RGB24}) {
    kernel = FakeKernel{};
    camera().format = format;
    camera().bytes_per_pixel = 2;
    if (format == V4L2_PIX_FMT_NV12 || format == V4L2_PIX_FMT_SGBRG8) camera().bytes_per_pixel = 1;
    if (format == V4L2_PIX_FMT_RGB24) camera().bytes_per_pixel = 3;
    V4l2Node node;
    node.configure(setup_of(0), kNews, kFake);
    V4l2Image images[2];
    ASSERT_EQ(node.take(images[0]), Status::kEmpty) << kernel.told.back();
    for (int i = 0; i < 2; ++i) {
      camera().shoot({now(), uint32_t(i), uint8_t(100 + i)});
      ASSERT_EQ(node.take(images[i]), Status::kOk);
    }
    EXPECT_EQ(node.counters().converted, format == V4L2_PIX_FMT_NV12 ? 0u : 2u) << format;
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(images[i].stride, kWidth);
      for (size_t k = 0; k < kBytes; ++k) ASSERT_EQ(images[i].data[k], 100 + i) << format;
      node.give_back(images[i].buffer);
    }
  }
}

// As rkisp1 has it, which has no other interface.
TEST_F(V4l2NodeTest, TheMultiPlanarInterfaceLendsTheLumaToo) {
  for (const uint32_t format : {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_NV12M}) {
    kernel = FakeKernel{};
    camera().multiplanar = true;
    camera().format = format;
    V4l2Node node;
    node.configure(setup_of(0), kNews, kFake);
    V4l2Image image;
    ASSERT_EQ(node.take(image), Status::kEmpty) << kernel.told.back();
    for (uint32_t i = 0; i < 2 * V4l2Node::kBuffers; ++i) {
      camera().shoot({now(), i, uint8_t(100 + i)});
      ASSERT_EQ(node.take(image), Status::kOk);
      EXPECT_EQ(image.data, camera().memory[i % V4l2Node::kBuffers].data()) << "no copy";
      EXPECT_EQ(image.data[kBytes - 1], 100 + i);
      node.give_back(image.buffer);
    }
    Shot cut = {now(), 99};
    cut.cut = 1;
    camera().shoot(cut);
    EXPECT_EQ(node.take(image), Status::kEmpty);
    EXPECT_EQ(node.counters().damaged, 1u) << "its plane is too short";
    EXPECT_EQ(node.counters().converted, 0u);
  }
}

TEST_F(V4l2NodeTest, TheRangeOfVideoIsStretchedWhereItIsToldOrSet) {
  const struct {
    uint32_t told;
    GreyRange set;
    int grey;  // of 126
  } cases[] = {{V4L2_QUANTIZATION_DEFAULT, GreyRange::kDriver, 126},
               {V4L2_QUANTIZATION_LIM_RANGE, GreyRange::kDriver, 128},
               {V4L2_QUANTIZATION_LIM_RANGE, GreyRange::kFull, 126},
               {V4L2_QUANTIZATION_FULL_RANGE, GreyRange::kLimited, 128}};
  for (const auto& c : cases) {
    for (const uint32_t format : {V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_YUYV}) {
      kernel = FakeKernel{};
      camera().format = format;
      camera().bytes_per_pixel = format == V4L2_PIX_FMT_GREY ? 1 : 2;
      camera().quantization = c.told;
      V4l2Setup setup = setup_of(0);
      setup.range = c.set;
      V4l2Node node;
      node.configure(setup, kNews, kFake);
      V4l2Image image;
      ASSERT_EQ(node.take(image), Status::kEmpty);
      camera().shoot({now(), 0, 126});
      ASSERT_EQ(node.take(image), Status::kOk);
      EXPECT_EQ(image.data[kBytes - 1], c.grey);
      node.give_back(image.buffer);
    }
  }
}

TEST_F(V4l2NodeTest, ABrokenJpegIsCountedAndTheNextOneShown) {
  camera().format = V4L2_PIX_FMT_MJPEG;
  V4l2Setup setup = setup_of(0);
  // One whose bytes are all 13 is broken.
  setup.jpeg = [](const uint8_t* data, size_t size, int width, int height, uint8_t* out) {
    if (data[0] == 13) return false;
    EXPECT_EQ(size, kBytes - 7);
    std::fill(out, out + width * height, data[0]);
    return true;
  };
  start(setup);
  Shot jpeg = {begin_ + kMs, 0, 13};
  jpeg.cut = 7;
  camera().shoot(jpeg);
  jpeg.sequence = 1;
  jpeg.grey = 80;
  EXPECT_EQ(shot(jpeg).data[5], 80);
  EXPECT_EQ(node_.counters().damaged, 1u);
  EXPECT_EQ(camera().queued.size(), size_t{V4l2Node::kBuffers} - 1) << "it went back";
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
  camera().has_exposure(60);  // 6 ms
  start(setup_of(0));
  const TimeNs t = begin_ + 20 * kMs;
  camera().frame_sync(t - 16 * kMs, 8);
  camera().frame_sync(t + 123, 9);
  EXPECT_EQ(shot({t + 9 * kMs, 9}).t, t + 123 - 3 * kMs) << "exposure ends as the frame begins";
  EXPECT_EQ(shot({t + 50 * kMs, 10}).t, us(t + 50 * kMs) + 3 * kMs) << "no event: the stamp";
  EXPECT_EQ(node_.counters().frame_sync_missed, 1u);
}

TEST_F(V4l2NodeTest, TellsExposureAndGainInTheUnitsOfUvc) {
  camera().has_exposure(60);
  camera().controls[V4L2_CID_EXPOSURE_AUTO] = {0, 3, V4L2_EXPOSURE_APERTURE_PRIORITY};
  camera().controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY] = {0, 1, 1};
  camera().controls[V4L2_CID_GAIN] = {0, 255, 64};
  V4l2Setup setup = setup_of(0);
  setup.controls.gain_one = 32;
  start(setup);
  const CameraRange range = node_.controls().range();
  EXPECT_EQ(range.exposure_ns_min, 100'000);
  EXPECT_EQ(range.exposure_ns_max, 500 * kMs);
  EXPECT_EQ(range.exposure_ns_step, 100'000);
  EXPECT_EQ(range.gain_min, 1);
  EXPECT_FLOAT_EQ(range.gain_max, 255 / 32.0f);
  node_.control({7'360'000, 2.51f});
  EXPECT_EQ(camera().controls[V4L2_CID_EXPOSURE_AUTO].now, V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(camera().controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY].now, 0);
  EXPECT_EQ(camera().controls[V4L2_CID_EXPOSURE_ABSOLUTE].now, 74);
  EXPECT_EQ(camera().controls[V4L2_CID_GAIN].now, 80);
  node_.control({0, 0});
  EXPECT_EQ(camera().controls[V4L2_CID_EXPOSURE_AUTO].now, V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(node_.counters().control_refused, 0u);
}

// 784 + 144 pixels at 46.4 MHz: 20 us a line.
TEST_F(V4l2NodeTest, TellsASensorItsExposureInLines) {
  camera().controls[V4L2_CID_EXPOSURE] = {4, 500, 200};
  camera().controls[V4L2_CID_HBLANK] = {144, 144, 144, 1, V4L2_CTRL_FLAG_READ_ONLY};
  camera().controls[V4L2_CID_ANALOGUE_GAIN] = {16, 248, 16};
  camera().pixel_rate = 46'400'000;
  camera().sensor_width = 784;
  V4l2Setup setup = setup_of(0);
  setup.controls.sensor = "/dev/v4l-subdev0";
  start(setup);
  EXPECT_EQ(shot({begin_ + kMs, 0}).exposure_ns, 4 * kMs) << "as it was found";
  node_.control({3 * kMs, 1.5f});
  EXPECT_EQ(camera().controls[V4L2_CID_EXPOSURE].now, 150);
  EXPECT_EQ(camera().controls[V4L2_CID_ANALOGUE_GAIN].now, 24);
  EXPECT_FLOAT_EQ(node_.controls().range().gain_max, 15.5f);
}

TEST_F(V4l2NodeTest, WithoutAPixelRateOrAKnownGainThereIsNoControl) {
  camera().controls[V4L2_CID_EXPOSURE] = {4, 500, 200};
  start(setup_of(0));
  EXPECT_FALSE(node_.controls().takes_exposure());
  kernel = FakeKernel{};
  camera().has_exposure(60);
  camera().controls[V4L2_CID_GAIN] = {0, 255, 64};
  V4l2Node node;
  node.configure(setup_of(0), kNews, kFake);
  V4l2Image none;
  ASSERT_EQ(node.take(none), Status::kEmpty);
  EXPECT_EQ(node.controls().range().gain_max, 1) << "nobody knows what the code does";
  node.control({5 * kMs, 1});
  EXPECT_EQ(camera().controls[V4L2_CID_GAIN].now, 64);
}

// Stamps need the exposure of the very image: a command is true two images later.
TEST_F(V4l2NodeTest, AnImageSaysTheExposureItWasTakenWith) {
  camera().has_exposure(60);
  start(setup_of(0));
  const TimeNs t = begin_ + 20 * kMs;
  EXPECT_EQ(shot({t, 5}).exposure_ns, 6 * kMs);
  node_.control({10 * kMs, 1});
  EXPECT_EQ(node_.exposure_of(6), 6 * kMs) << "of those to come";
  EXPECT_EQ(node_.exposure_of(7), 10 * kMs);
  EXPECT_EQ(shot({t + 50 * kMs, 6}).exposure_ns, 6 * kMs);
  EXPECT_EQ(shot({t + 100 * kMs, 7}).t, us(t + 100 * kMs) + 5 * kMs);
  EXPECT_EQ(node_.counters().exposure_changed, 0u);
}

TEST_F(V4l2NodeTest, AnotherProgramsExposureIsCountedAndSetAgain) {
  camera().has_exposure(60);
  camera().controls[V4L2_CID_GAIN] = {1, 16, 1};
  start(setup_of(0));
  (void)shot({begin_ + kMs, 0});
  camera().has_exposure(50);
  EXPECT_EQ(shot({begin_ + 2 * kMs, 1}).exposure_ns, 5 * kMs) << "nobody has told it anything";
  EXPECT_EQ(node_.counters().exposure_changed, 0u);
  node_.control({8 * kMs, 2});
  camera().has_exposure(300);
  EXPECT_EQ(shot({begin_ + 3 * kMs, 2}).exposure_ns, 30 * kMs);
  EXPECT_EQ(camera().controls[V4L2_CID_EXPOSURE_ABSOLUTE].now, 80);
  EXPECT_EQ(node_.counters().exposure_changed, 1u);
  camera().controls[V4L2_CID_GAIN].now = 9;
  for (uint32_t i = 3; i < 20; ++i) {
    node_.give_back(shot({begin_ + TimeNs(i) * kMs, i}).buffer);
  }
  EXPECT_EQ(camera().controls[V4L2_CID_GAIN].now, 2);
  EXPECT_EQ(node_.counters().exposure_changed, 2u);
}

TEST_F(V4l2NodeTest, ACameraThatComesBackIsToldAgain) {
  camera().has_exposure(60);
  start(setup_of(0));
  node_.control({8 * kMs, 1});
  camera().plugged = false;
  V4l2Image none;
  EXPECT_EQ(node_.take(none), Status::kBusFault);
  camera().has_exposure(60);
  node_.control({9 * kMs, 1});
  EXPECT_EQ(camera().controls[V4L2_CID_EXPOSURE_ABSOLUTE].now, 60) << "it is not there";
  camera().plugged = true;
  const TimeNs begin = now();
  while (!node_.is_open() && now() < begin + 3 * V4l2Node::kRetry_ns) (void)node_.take(none);
  EXPECT_EQ(camera().controls[V4L2_CID_EXPOSURE_ABSOLUTE].now, 90);
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

TEST_F(V4l2NodeTest, OneThatStallsIsStartedAnewUntilImagesCome) {
  V4l2Setup setup = setup_of(0);
  setup.stall_ns = 20 * kMs;
  start(setup);
  const V4l2Image kept = shot({begin_ + kMs, 5});
  camera().stalls_for = 2;
  V4l2Image image;
  const TimeNs until = now() + 3000 * kMs;
  while (camera().stalls_for > 0 && now() < until) {
    camera().shoot({now(), 6});
    EXPECT_EQ(node_.take(image), Status::kEmpty);
  }
  EXPECT_EQ(node_.counters().stalled, 2u);
  EXPECT_TRUE(node_.stalls());
  EXPECT_EQ(camera().queued.size(), size_t{V4l2Node::kBuffers} - 1) << "but the one that is lent";
  (void)shot({now() + kMs, 0});
  EXPECT_FALSE(node_.stalls());
  EXPECT_EQ(node_.counters().lost, 0u) << "it counts anew";
  EXPECT_EQ(node_.counters().unplugged, 0u);
  EXPECT_EQ(kernel.told.size(), 3u) << "once that it stalls, and that it goes on";
  node_.give_back(kept.buffer);
  EXPECT_EQ(node_.take(image), Status::kEmpty);
  EXPECT_EQ(camera().queued.size(), size_t{V4l2Node::kBuffers} - 1);
  camera().plugged = false;
  const TimeNs gone = now() + 3000 * kMs;
  while (node_.is_open() && now() < gone) (void)node_.take(image);
  EXPECT_EQ(node_.counters().unplugged, 1u);
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
      {"the camera cannot give the calibration's size in a format that can be made grey",
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
