// The two sides of the gadget's camera, against a kernel of the test's own.
#include <errno.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "board/linux/image_share.h"
#include "board/usb/uvc_feeder.h"
#include "board/usb/uvc_holder.h"

namespace pirvs::board {
namespace {

constexpr int kWidth = 32, kHeight = 16;
constexpr size_t kBytes = size_t{kWidth} * kHeight;
constexpr int kNode = 50;

// A node of f_uvc, and the host behind it.
struct FakeNode {
  std::mutex lock;
  bool plugged = true, streaming = false, refuses_stream = false;
  uint32_t width = 0, format = 0, buffers = 0;
  std::vector<uint32_t> subscribed;
  std::deque<v4l2_event> events;
  std::vector<uvc_request_data> answers;
  std::vector<uint8_t> memory[kUvcBuffers];
  uint32_t flags[kUvcBuffers] = {};
  std::deque<uint32_t> queued, done;
  std::vector<uint8_t> shown;  // first pixels of the images that went to the host

  void event(uint32_t type, const usb_ctrlrequest& request = {}) {
    v4l2_event out{};
    out.type = type;
    std::memcpy(&out.u.data, &request, sizeof request);
    events.push_back(out);
  }
  // The host takes the oldest image.
  bool take() {
    const std::lock_guard<std::mutex> held(lock);
    if (!streaming || queued.empty()) return false;
    const uint32_t i = queued.front();
    queued.pop_front();
    shown.push_back(memory[i][0]);
    for (const uint8_t pixel : memory[i]) EXPECT_EQ(pixel, memory[i][0]);
    flags[i] = V4L2_BUF_FLAG_DONE;
    done.push_back(i);
    return true;
  }
};
FakeNode* node = nullptr;

int failed(int error) {
  errno = error;
  return -1;
}

int stream(bool on) {
  if (on && node->refuses_stream) return failed(EIO);
  node->streaming = on;
  if (on) return 0;
  node->queued.clear();
  node->done.clear();
  for (uint32_t& flags : node->flags) flags = 0;
  return 0;
}

int queue(v4l2_buffer& buffer) {
  if (node->flags[buffer.index] != 0 || buffer.bytesused != kBytes) return failed(EINVAL);
  node->flags[buffer.index] = V4L2_BUF_FLAG_QUEUED;
  node->queued.push_back(buffer.index);
  return 0;
}

template <class T>
int take(std::deque<T>& from, T& out, int when_empty) {
  if (from.empty()) return failed(when_empty);
  out = from.front();
  from.pop_front();
  return 0;
}

int fake_ioctl(int, unsigned long request, void* argument) {
  const std::lock_guard<std::mutex> held(node->lock);
  auto& buffer = *static_cast<v4l2_buffer*>(argument);
  if (!node->plugged) return failed(ENODEV);
  switch (request) {
    case VIDIOC_S_FMT:
      node->width = static_cast<v4l2_format*>(argument)->fmt.pix.width;
      node->format = static_cast<v4l2_format*>(argument)->fmt.pix.pixelformat;
      return 0;
    case VIDIOC_REQBUFS:
      node->buffers = static_cast<v4l2_requestbuffers*>(argument)->count;
      return 0;
    case VIDIOC_SUBSCRIBE_EVENT:
      node->subscribed.push_back(static_cast<v4l2_event_subscription*>(argument)->type);
      return 0;
    case VIDIOC_DQEVENT:
      return take(node->events, *static_cast<v4l2_event*>(argument), ENOENT);
    case UVCIOC_SEND_RESPONSE:
      node->answers.push_back(*static_cast<uvc_request_data*>(argument));
      return 0;
    case VIDIOC_STREAMON:
    case VIDIOC_STREAMOFF:
      return stream(request == VIDIOC_STREAMON);
    case VIDIOC_QUERYBUF:
      buffer.length = kBytes;
      buffer.m.offset = buffer.index;
      buffer.flags = node->flags[buffer.index];
      return 0;
    case VIDIOC_QBUF:
      return queue(buffer);
    case VIDIOC_DQBUF: {
      const int result = take(node->done, buffer.index, EAGAIN);
      if (result == 0) node->flags[buffer.index] = 0;
      return result;
    }
    default:
      return failed(ENOTTY);
  }
}

const bsp::SystemCalls kFake = {[](const char*) { return node->plugged ? kNode : failed(ENOENT); },
                                [](int) { return 0; }, fake_ioctl,
                                [](size_t, int, int64_t offset) {
                                  return static_cast<void*>(node->memory[size_t(offset)].data());
                                },
                                [](void*, size_t) { return 0; }};

class UvcTest : public testing::Test {
 protected:
  void SetUp() override {
    node = &node_;
    for (auto& memory : node_.memory) memory.assign(kBytes, 0);
    format_.width = kWidth;
    format_.height = kHeight;
  }
  FakeNode node_;
  UvcFormat format_;
};

using UvcHolderTest = UvcTest;

TEST_F(UvcHolderTest, AppearsOnTheBusWhenAllIsReady) {
  UvcHolder holder;
  ASSERT_EQ(holder.open("/dev/video0", format_, kFake), nullptr);
  EXPECT_EQ(node_.width, uint32_t(kWidth));
  EXPECT_EQ(node_.format, V4L2_PIX_FMT_GREY);
  EXPECT_EQ(node_.buffers, kUvcBuffers);
  ASSERT_FALSE(node_.subscribed.empty());
  EXPECT_EQ(node_.subscribed.back(), uint32_t(UVC_EVENT_SETUP));
  holder.close();
}

TEST_F(UvcHolderTest, AnswersEachRequest) {
  UvcHolder holder;
  ASSERT_EQ(holder.open("/dev/video0", format_, kFake), nullptr);
  usb_ctrlrequest request{};
  request.bRequestType = USB_DIR_IN | USB_TYPE_CLASS | USB_RECIP_INTERFACE;
  request.bRequest = UVC_GET_CUR;
  request.wValue = UVC_VS_PROBE_CONTROL << 8;
  request.wIndex = format_.streaming_interface;
  request.wLength = 34;
  node_.event(UVC_EVENT_SETUP, request);
  request.wIndex = 0x0200;
  node_.event(UVC_EVENT_SETUP, request);
  EXPECT_TRUE(holder.on_events());
  ASSERT_EQ(node_.answers.size(), 2u);
  EXPECT_EQ(node_.answers[0].length, 34);
  EXPECT_LT(node_.answers[1].length, 0);
  holder.close();
}

TEST_F(UvcHolderTest, StartsAndStopsTheStreamItself) {
  UvcHolder holder;
  ASSERT_EQ(holder.open("/dev/video0", format_, kFake), nullptr);
  for (const uint32_t end : {uint32_t(UVC_EVENT_STREAMOFF), uint32_t(UVC_EVENT_DISCONNECT)}) {
    node_.event(UVC_EVENT_STREAMON);
    EXPECT_TRUE(holder.on_events());
    EXPECT_TRUE(holder.streaming() && node_.streaming);
    node_.event(end);
    EXPECT_TRUE(holder.on_events());
    EXPECT_FALSE(holder.streaming() || node_.streaming);
  }
  node_.refuses_stream = true;
  node_.event(UVC_EVENT_STREAMON);
  EXPECT_TRUE(holder.on_events());
  EXPECT_FALSE(holder.streaming());
  EXPECT_EQ(holder.refused(), 1u);
  holder.close();
}

TEST_F(UvcHolderTest, SaysWhenTheNodeIsGone) {
  UvcHolder holder;
  ASSERT_EQ(holder.open("/dev/video0", format_, kFake), nullptr);
  node_.plugged = false;
  EXPECT_FALSE(holder.on_events());
  EXPECT_NE(holder.open("/dev/video0", format_, kFake), nullptr);
}

// A feeder on a thread of its own, which ends with the pipe; and pirvsd's side of the images.
class UvcFeederTest : public UvcTest {
 protected:
  void SetUp() override {
    UvcTest::SetUp();
    path_ = testing::TempDir() + "pirvs_feeder_" + std::to_string(getpid());
    ASSERT_EQ(share_.open(path_.c_str(), 1, kWidth, kHeight), Status::kOk);
  }
  void start() {
    ASSERT_EQ(pipe(control_), 0);
    setup_.node = kNode;
    setup_.control = control_[0];
    setup_.images = path_.c_str();
    setup_.width = kWidth;
    setup_.height = kHeight;
    feeder_ = UvcFeeder();
    ASSERT_TRUE(feeder_.open(setup_, kFake));
    thread_ = std::thread([this] { feeder_.run(); });
  }
  // As when it is killed: nothing is taken back.
  void end() {
    close(control_[1]);
    thread_.join();
    close(control_[0]);
  }
  void TearDown() override { share_.close(); }

  void stream(bool on) {
    {
      const std::lock_guard<std::mutex> held(node_.lock);
      board::stream(on);
    }
    const uint8_t said = on;
    ASSERT_EQ(write(control_[1], &said, 1), 1);
  }
  void shoot(uint8_t grey) {
    std::vector<uint8_t> pixels(kBytes, grey);
    StereoFrame frame;
    frame.image[0] = {pixels.data(), kWidth, kHeight, kWidth};
    frame.present = 1;
    share_.frame(frame);
  }
  // Frames until one has come through; the share looks for clients ten times a second.
  bool shows_within(int frames) {
    for (int i = 0; i < frames; ++i) {
      shoot(grey_++);
      usleep(5000);
      if (node_.take()) return true;
    }
    return false;
  }

  ImageShare share_;
  UvcFeeder feeder_;
  FeederSetup setup_;
  std::string path_;
  int control_[2] = {};
  std::thread thread_;
  uint8_t grey_ = 1;
};

TEST_F(UvcFeederTest, ShowsImagesInOrderWhileAHostLooks) {
  start();
  stream(true);
  ASSERT_TRUE(shows_within(400));
  node_.shown.clear();
  for (uint8_t grey = 100; grey < 130; ++grey) {
    shoot(grey);
    for (int i = 0; i < 400 && !node_.take(); ++i) usleep(1000);
  }
  ASSERT_EQ(node_.shown.size(), 30u);
  for (size_t i = 0; i < 30; ++i) EXPECT_EQ(node_.shown[i], 100 + i);
  stream(false);
  usleep(50'000);
  const uint32_t sent = share_.counters().sent;
  for (int i = 0; i < 20; ++i) shoot(1);
  EXPECT_LE(share_.counters().sent, sent + 1) << "nobody looks";
  end();
}

TEST_F(UvcFeederTest, DropsImagesThatTheBusHasNoTimeFor) {
  start();
  stream(true);
  ASSERT_TRUE(shows_within(400));
  for (int i = 0; i < 30; ++i) {
    shoot(50);
    usleep(5000);
  }
  {
    const std::lock_guard<std::mutex> held(node_.lock);
    EXPECT_EQ(node_.queued.size(), kUvcBuffers);
  }
  EXPECT_EQ(share_.counters().lost, 0u) << "pirvsd has its slots back";
  while (node_.take()) continue;
  EXPECT_TRUE(shows_within(20));
  end();
}

// The next one begins with the buffers as its predecessor left them.
TEST_F(UvcFeederTest, GoesOnWhereAKilledOneStopped) {
  start();
  stream(true);
  ASSERT_TRUE(shows_within(400));
  shoot(1);
  shoot(2);
  usleep(20'000);
  end();
  start();
  const uint8_t on = 1;
  ASSERT_EQ(write(control_[1], &on, 1), 1);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(shows_within(400)) << i;
  end();
}

TEST_F(UvcFeederTest, SaysWhatIsWrongOnceAndWaits) {
  static std::atomic<int> told;
  told = 0;
  setup_.tell = [](const char*) { ++told; };
  share_.close();
  start();
  stream(true);
  usleep(700'000);
  EXPECT_EQ(told, 1);
  ASSERT_EQ(share_.open(path_.c_str(), 1, kWidth, kHeight), Status::kOk);
  EXPECT_TRUE(shows_within(400));
  end();
}

}  // namespace
}  // namespace pirvs::board
