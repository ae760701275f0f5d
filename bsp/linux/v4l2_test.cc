// Node and pair against a kernel of our own: two cameras that give what a test says.
#include <errno.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "bsp/api/clock.h"
#include "bsp/linux/v4l2_node.h"
#include "bsp/linux/v4l2_stereo.h"

namespace pirvs::bsp {
namespace {

constexpr int kWidth = 64, kHeight = 32;
constexpr size_t kBytes = size_t{kWidth} * kHeight;
constexpr TimeNs kMs = 1'000'000;

struct Shot {
  TimeNs t = 0;
  uint32_t sequence = 0;
  uint8_t grey = 0;
  uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  size_t bytes = kBytes;
};

struct FakeCamera {
  int open_error = 0;
  bool plugged = true, streaming = false;
  uint32_t format = V4L2_PIX_FMT_GREY, buffers_granted = 32;
  int32_t exposure = -1;  // 100 us; -1: no such control
  bool has_frame_sync = false;
  std::vector<std::vector<uint8_t>> memory;
  std::deque<uint32_t> queued;
  std::deque<v4l2_buffer> done;
  std::deque<v4l2_event> events;
  uint32_t without_buffer = 0;  // shots that no buffer was there for

  // As a sensor does: without a buffer the image is lost.
  void shoot(const Shot& shot) {
    if (!streaming || queued.empty()) {
      ++without_buffer;
      return;
    }
    v4l2_buffer buffer{};
    buffer.index = queued.front();
    queued.pop_front();
    std::memset(memory[buffer.index].data(), shot.grey, kBytes);
    buffer.timestamp.tv_sec = shot.t / 1'000'000'000;
    buffer.timestamp.tv_usec = shot.t % 1'000'000'000 / 1000;
    buffer.sequence = shot.sequence;
    buffer.flags = shot.flags;
    buffer.bytesused = static_cast<uint32_t>(shot.bytes);
    done.push_back(buffer);
  }
  void frame_sync(TimeNs t, uint32_t sequence) {
    v4l2_event event{};
    event.type = V4L2_EVENT_FRAME_SYNC;
    event.u.frame_sync.frame_sequence = sequence;
    event.timestamp.tv_sec = t / 1'000'000'000;
    event.timestamp.tv_nsec = t % 1'000'000'000;
    events.push_back(event);
  }
};

struct FakeKernel {
  FakeCamera cameras[2];
  std::vector<std::string> told;
};
FakeKernel kernel;  // anew for each test

int failed(int error) {
  errno = error;
  return -1;
}

int fake_open(const char* path) {
  const int c = path[std::strlen(path) - 1] - '0';
  FakeCamera& camera = kernel.cameras[c];
  if (!camera.plugged) return failed(ENOENT);
  if (camera.open_error != 0) return failed(camera.open_error);
  return 100 + c;
}

int fake_close(int fd) {
  FakeCamera& camera = kernel.cameras[fd - 100];
  camera.streaming = false;
  camera.queued.clear();
  camera.done.clear();
  return 0;
}

template <class T>
int take(std::deque<T>& from, void* out, int when_empty) {
  if (from.empty()) return failed(when_empty);
  *static_cast<T*>(out) = from.front();
  from.pop_front();
  return 0;
}

int set_format(const FakeCamera& camera, v4l2_pix_format& pix) {
  pix.width = kWidth;
  pix.height = kHeight;
  pix.pixelformat = camera.format;
  pix.bytesperline = kWidth;
  return 0;
}

int grant(FakeCamera& camera, v4l2_requestbuffers& request) {
  request.count = std::min(request.count, camera.buffers_granted);
  camera.memory.assign(request.count, std::vector<uint8_t>(kBytes));
  return 0;
}

int fake_ioctl(int fd, unsigned long request, void* argument) {
  FakeCamera& camera = kernel.cameras[fd - 100];
  if (!camera.plugged) return failed(ENODEV);
  switch (request) {
    case VIDIOC_QUERYCAP:
      static_cast<v4l2_capability*>(argument)->capabilities =
          V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      return 0;
    case VIDIOC_S_FMT:
      return set_format(camera, static_cast<v4l2_format*>(argument)->fmt.pix);
    case VIDIOC_REQBUFS:
      return grant(camera, *static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      buffer.length = kBytes;
      buffer.m.offset = buffer.index;
      return 0;
    }
    case VIDIOC_QBUF:
      camera.queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return take(camera.done, argument, EAGAIN);
    case VIDIOC_STREAMON:
      camera.streaming = true;
      return 0;
    case VIDIOC_SUBSCRIBE_EVENT:
      return camera.has_frame_sync ? 0 : failed(EINVAL);
    case VIDIOC_DQEVENT:
      return take(camera.events, argument, ENOENT);
    case VIDIOC_G_CTRL:
      static_cast<v4l2_control*>(argument)->value = camera.exposure;
      return camera.exposure >= 0 ? 0 : failed(EINVAL);
    default:
      return failed(ENOTTY);
  }
}

void* fake_map(size_t, int fd, int64_t offset) {
  return kernel.cameras[fd - 100].memory[size_t(offset)].data();
}

int fake_unmap(void*, size_t) { return 0; }

constexpr SystemCalls kFake = {fake_open, fake_close, fake_ioctl, fake_map, fake_unmap};

const DeviceNews kNews = {nullptr, [](void*, const char* device, const char* what) {
                            kernel.told.push_back(std::string(device) + ": " + what);
                          }};

V4l2Setup setup_of(int c) {
  V4l2Setup setup;
  setup.path = c == 0 ? "/dev/video0" : "/dev/video1";
  setup.width = kWidth;
  setup.height = kHeight;
  return setup;
}

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
  cut.bytes = kBytes - 1;
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
      {"the camera cannot give the calibration's size as 8-bit grey",
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

TEST_F(V4l2StereoTest, OneCameraAloneIsAFrameOfItsOwn) {
  start(Pairing::kTrigger, 1);
  pulse(0, 1);
  EXPECT_EQ(next().present, 1);
  pulse(5, 1);
  EXPECT_EQ(next().lost_before, 4u);
}

}  // namespace
}  // namespace pirvs::bsp
