#include "board/usb/uvc_holder.h"

#include <errno.h>
#include <linux/videodev2.h>

namespace pirvs::board {
namespace {

// UVC_EVENT_SETUP last: with it the gadget appears.
constexpr uint32_t kEvents[] = {UVC_EVENT_STREAMON, UVC_EVENT_STREAMOFF, UVC_EVENT_DISCONNECT,
                                UVC_EVENT_DATA, UVC_EVENT_SETUP};

}  // namespace

const char* UvcHolder::open(const char* path, const UvcFormat& format,
                            const bsp::SystemCalls& calls) {
  calls_ = &calls;
  control_.configure(format);
  fd_ = calls_->open(path);
  if (fd_ < 0) return "the camera's node cannot be opened";
  v4l2_format pixels{};
  pixels.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  pixels.fmt.pix.width = static_cast<uint32_t>(format.width);
  pixels.fmt.pix.height = static_cast<uint32_t>(format.height);
  pixels.fmt.pix.pixelformat = V4L2_PIX_FMT_GREY;
  pixels.fmt.pix.sizeimage = static_cast<uint32_t>(format.width * format.height);
  if (calls_->ioctl(fd_, VIDIOC_S_FMT, &pixels) < 0) return "the camera's format is refused";
  v4l2_requestbuffers request{};
  request.count = kUvcBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  request.memory = V4L2_MEMORY_MMAP;
  if (calls_->ioctl(fd_, VIDIOC_REQBUFS, &request) < 0 || request.count != kUvcBuffers) {
    return "no memory for the camera's images";
  }
  for (const uint32_t event : kEvents) {
    v4l2_event_subscription wanted{};
    wanted.type = event;
    if (calls_->ioctl(fd_, VIDIOC_SUBSCRIBE_EVENT, &wanted) < 0) {
      return errno == EBUSY ? "another program holds the camera" : "no events of the camera";
    }
  }
  return nullptr;
}

void UvcHolder::close() {
  if (fd_ >= 0) calls_->close(fd_);
  fd_ = -1;
  streaming_ = false;
}

bool UvcHolder::stream(bool on) {
  int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  const bool done = calls_->ioctl(fd_, on ? VIDIOC_STREAMON : VIDIOC_STREAMOFF, &type) == 0;
  refused_ += !done;
  streaming_ = on && done;
  return done;
}

bool UvcHolder::on_events() {
  v4l2_event event{};
  while (calls_->ioctl(fd_, VIDIOC_DQEVENT, &event) == 0) {
    const auto& uvc = reinterpret_cast<const uvc_event&>(event.u.data);
    switch (event.type) {
      case UVC_EVENT_SETUP: {
        uvc_request_data answer = control_.answer(uvc.req);
        refused_ += calls_->ioctl(fd_, UVCIOC_SEND_RESPONSE, &answer) < 0;
        break;
      }
      case UVC_EVENT_STREAMON:
        if (!stream(true)) (void)stream(false);
        break;
      case UVC_EVENT_STREAMOFF:
      case UVC_EVENT_DISCONNECT:
        if (streaming_) (void)stream(false);
        break;
      default:
        break;
    }
  }
  return errno == ENOENT || errno == EAGAIN;  // there are no more
}

}  // namespace pirvs::board
