#include "board/usb/uvc_feeder.h"

#include <linux/videodev2.h>
#include <poll.h>
#include <unistd.h>

#include <cstring>

namespace pirvs::board {
namespace {

constexpr int kRetry_ms = 500;

v4l2_buffer buffer_of(uint32_t index) {
  v4l2_buffer out{};
  out.index = index;
  out.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  out.memory = V4L2_MEMORY_MMAP;
  return out;
}

}  // namespace

bool UvcFeeder::open(const FeederSetup& setup, const bsp::SystemCalls& calls) {
  setup_ = setup;
  calls_ = &calls;
  for (uint32_t i = 0; i < kUvcBuffers; ++i) {
    v4l2_buffer buffer = buffer_of(i);
    if (calls_->ioctl(setup_.node, VIDIOC_QUERYBUF, &buffer) < 0) return false;
    if (buffer.length < bytes()) return false;
    buffers_[i] = static_cast<uint8_t*>(calls_->map(buffer.length, setup_.node, buffer.m.offset));
    if (buffers_[i] == nullptr) return false;
  }
  return true;
}

void UvcFeeder::tell(const char* what) {
  if (what != told_ && what != nullptr && setup_.tell != nullptr) setup_.tell(what);
  told_ = what;
}

// ---- buffers -----------------------------------------------------------------------------------

// What a predecessor has queued, and what the end of a stream has given back.
void UvcFeeder::look_at_buffers() {
  for (uint32_t i = 0; i < kUvcBuffers; ++i) {
    v4l2_buffer buffer = buffer_of(i);
    const bool known = calls_->ioctl(setup_.node, VIDIOC_QUERYBUF, &buffer) == 0;
    queued_[i] = !known || (buffer.flags & (V4L2_BUF_FLAG_QUEUED | V4L2_BUF_FLAG_DONE)) != 0;
  }
}

void UvcFeeder::take_back() {
  v4l2_buffer buffer = buffer_of(0);
  while (calls_->ioctl(setup_.node, VIDIOC_DQBUF, &buffer) == 0) {
    if (buffer.index < kUvcBuffers) queued_[buffer.index] = false;
  }
}

bool UvcFeeder::show(const uint8_t* pixels) {
  take_back();
  uint32_t free = 0;
  while (free < kUvcBuffers && queued_[free]) ++free;
  if (free == kUvcBuffers) return false;
  std::memcpy(buffers_[free], pixels, bytes());
  v4l2_buffer buffer = buffer_of(free);
  buffer.bytesused = static_cast<uint32_t>(bytes());
  queued_[free] = calls_->ioctl(setup_.node, VIDIOC_QBUF, &buffer) == 0;
  return queued_[free];
}

// ---- the holder, and pirvsd --------------------------------------------------------------------

bool UvcFeeder::obey_holder() {
  uint8_t said = 0;
  if (read(setup_.control, &said, 1) != 1) return false;
  streaming_ = said != 0;
  if (streaming_) look_at_buffers();
  return true;
}

void UvcFeeder::follow_stream() {
  if (!streaming_) client_.close();
  if (!streaming_ || client_.is_open()) return;
  const Status status = client_.connect(setup_.images, setup_.camera);
  if (status != Status::kOk) {
    tell(status == Status::kNotFound ? "no images: pirvsd is not there, or another program has them"
                                     : "no images: pirvsd talks otherwise");
    return;
  }
  const ImageRing& ring = client_.ring();
  if (ring.width == static_cast<uint32_t>(setup_.width) &&
      ring.height == static_cast<uint32_t>(setup_.height)) {
    return tell(nullptr);
  }
  client_.close();
  tell("no images: usb.size is not that of pirvsd's images");
}

void UvcFeeder::take_images() {
  ImageReady image;
  while (client_.is_open() && client_.next(image) == Status::kOk) {
    (void)show(client_.pixels(image));
    client_.give_back(image);
  }
}

void UvcFeeder::run() {
  for (;;) {
    pollfd polled[2] = {{setup_.control, POLLIN, 0}, {client_.fd(), POLLIN, 0}};
    const int timeout_ms = streaming_ && !client_.is_open() ? kRetry_ms : -1;
    if (poll(polled, 2, timeout_ms) < 0) continue;
    if (polled[0].revents != 0 && !obey_holder()) break;
    if (polled[1].revents != 0) take_images();
    follow_stream();
  }
  client_.close();
}

}  // namespace pirvs::board
