// A kernel with two V4L2 cameras that give what a test says, for bsp/linux/system_calls.h.
// In      kernel.cameras[c]: shoot(), frame_sync(), and whether it is plugged, busy, odd.
// Out     kernel.told: what the driver told a person.
// Errors  as a kernel's, by errno.
#pragma once

#include <errno.h>
#include <linux/v4l2-subdev.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "bsp/linux/v4l2_node.h"

namespace pirvs::bsp {

inline constexpr int kWidth = 64, kHeight = 32;
inline constexpr size_t kBytes = size_t{kWidth} * kHeight;
inline constexpr TimeNs kMs = 1'000'000;

struct Shot {
  TimeNs t = 0;
  uint32_t sequence = 0;
  uint8_t grey = 0;
  uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  size_t cut = 0;  // bytes that are missing at its end
};

// A control of a camera, or of its sensor.
struct FakeControl {
  int32_t min = 0, max = 0, now = 0, step = 1;
  uint32_t flags = 0;
};

struct FakeCamera {
  int open_error = 0;
  bool plugged = true, streaming = false;
  bool multiplanar = false;  // the colour of NV12M is a plane of its own
  uint32_t format = V4L2_PIX_FMT_GREY, buffers_granted = 32;
  int bytes_per_pixel = 1;
  uint32_t quantization = V4L2_QUANTIZATION_DEFAULT;
  std::map<uint32_t, FakeControl> controls;
  int64_t pixel_rate = 0;
  uint32_t sensor_width = 0;  // of its subdev
  int times_set = 0;
  bool has_frame_sync = false;
  std::vector<std::vector<uint8_t>> memory;
  std::deque<uint32_t> queued;
  std::deque<v4l2_buffer> done;
  std::deque<v4l2_event> events;
  void has_exposure(int32_t units_of_100_us) {
    controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {1, 5000, units_of_100_us};
  }
  int stalls_for = 0;           // so many starts of the stream
  uint32_t without_buffer = 0;  // shots that no buffer was there for

  size_t size() const { return kBytes * size_t(bytes_per_pixel); }
  // Whose every byte is the grey.
  bool is_plain() const {
    return format == V4L2_PIX_FMT_NV12 || format == V4L2_PIX_FMT_NV12M ||
           format == V4L2_PIX_FMT_SGBRG8 || format == V4L2_PIX_FMT_RGB24 ||
           format == V4L2_PIX_FMT_MJPEG;
  }
  // One grey all over, in any format; colour and lower bits are noise.
  void fill(std::vector<uint8_t>& to, uint8_t grey) const {
    for (size_t i = 0; i < to.size(); ++i) to[i] = uint8_t(i * 37);
    for (size_t i = 0; i < kBytes; ++i) {
      uint8_t* const pixel = &to[i * size_t(bytes_per_pixel)];
      for (int k = 0; k < bytes_per_pixel && is_plain(); ++k) pixel[k] = grey;
      if (format == V4L2_PIX_FMT_GREY || format == V4L2_PIX_FMT_YUYV) pixel[0] = grey;
      if (format == V4L2_PIX_FMT_UYVY || format == V4L2_PIX_FMT_Y16) pixel[1] = grey;
      if (format == V4L2_PIX_FMT_Y10) pixel[0] = uint8_t(grey << 2 | 3);
      if (format == V4L2_PIX_FMT_Y10) pixel[1] = grey >> 6;
    }
  }
  // As a sensor does: without a buffer the image is lost.
  void shoot(const Shot& shot) {
    if (!streaming || queued.empty() || stalls_for > 0) {
      ++without_buffer;
      return;
    }
    v4l2_buffer buffer{};
    buffer.index = queued.front();
    queued.pop_front();
    fill(memory[buffer.index], shot.grey);
    buffer.timestamp.tv_sec = shot.t / 1'000'000'000;
    buffer.timestamp.tv_usec = shot.t % 1'000'000'000 / 1000;
    buffer.sequence = shot.sequence;
    buffer.flags = shot.flags;
    buffer.bytesused = static_cast<uint32_t>(size() - shot.cut);
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
inline FakeKernel kernel;  // anew for each test

// A camera's video node is 100, 101; its sensor's subdev, which has the same controls, 200, 201.
inline constexpr int kSensorFds = 200;

inline int failed(int error) {
  errno = error;
  return -1;
}

inline int query_control(const FakeCamera& camera, v4l2_queryctrl& query) {
  const auto found = camera.controls.find(query.id);
  if (found == camera.controls.end()) return failed(EINVAL);
  const FakeControl& control = found->second;
  query.minimum = control.min;
  query.maximum = control.max;
  query.step = control.step;
  query.flags = control.flags;
  return 0;
}

inline int get_control(const FakeCamera& camera, v4l2_control& out) {
  const auto found = camera.controls.find(out.id);
  if (found == camera.controls.end()) return failed(EINVAL);
  out.value = found->second.now;
  return 0;
}

inline int set_control(FakeCamera& camera, const v4l2_control& wanted) {
  const auto found = camera.controls.find(wanted.id);
  if (found == camera.controls.end()) return failed(EINVAL);
  const FakeControl& control = found->second;
  if (wanted.value < control.min || wanted.value > control.max) return failed(ERANGE);
  found->second.now = wanted.value;
  ++camera.times_set;
  return 0;
}

inline int get_pixel_rate(const FakeCamera& camera, v4l2_ext_controls& several) {
  if (camera.pixel_rate == 0 || several.controls->id != V4L2_CID_PIXEL_RATE) return failed(EINVAL);
  several.controls->value64 = camera.pixel_rate;
  return 0;
}

inline int fake_open(const char* path) {
  const int c = path[std::strlen(path) - 1] - '0';
  FakeCamera& camera = kernel.cameras[c];
  if (!camera.plugged) return failed(ENOENT);
  if (camera.open_error != 0) return failed(camera.open_error);
  return (std::strstr(path, "subdev") != nullptr ? kSensorFds : 100) + c;
}

inline int fake_close(int fd) {
  if (fd >= kSensorFds) return 0;
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

inline int set_format(const FakeCamera& camera, v4l2_format& format) {
  if (camera.multiplanar) {
    v4l2_pix_format_mplane& mp = format.fmt.pix_mp;
    mp.width = kWidth;
    mp.height = kHeight;
    mp.pixelformat = camera.format;
    mp.num_planes = camera.format == V4L2_PIX_FMT_NV12M ? 2 : 1;
    mp.plane_fmt[0].bytesperline = uint32_t(kWidth);
    mp.plane_fmt[1].bytesperline = uint32_t(kWidth);
    mp.quantization = uint8_t(camera.quantization);
    return 0;
  }
  v4l2_pix_format& pix = format.fmt.pix;
  pix.width = kWidth;
  pix.height = kHeight;
  pix.pixelformat = camera.format;
  pix.bytesperline = uint32_t(kWidth * camera.bytes_per_pixel);
  pix.quantization = camera.quantization;
  return 0;
}

inline int grant(FakeCamera& camera, v4l2_requestbuffers& request) {
  request.count = std::min(request.count, camera.buffers_granted);
  camera.memory.assign(request.count, std::vector<uint8_t>(camera.size()));
  return 0;
}

inline int query_buffer(const FakeCamera& camera, v4l2_buffer& buffer) {
  if (!camera.multiplanar) {
    buffer.length = uint32_t(camera.size());
    buffer.m.offset = buffer.index;
    return 0;
  }
  if (buffer.length < (camera.format == V4L2_PIX_FMT_NV12M ? 2u : 1u)) return failed(EINVAL);
  buffer.m.planes[0].length = uint32_t(camera.size());
  buffer.m.planes[0].m.mem_offset = buffer.index;
  buffer.m.planes[1].m.mem_offset = 1000;  // nobody is to map it
  return 0;
}

inline int dequeue(FakeCamera& camera, v4l2_buffer& out) {
  if (camera.done.empty()) return failed(EAGAIN);
  const v4l2_buffer asked = out;
  out = camera.done.front();
  camera.done.pop_front();
  out.type = asked.type;
  if (!camera.multiplanar) return 0;
  out.m.planes = asked.m.planes;
  out.length = asked.length;
  out.m.planes[0].bytesused = out.bytesused;
  out.bytesused = 0;
  return 0;
}

inline uint32_t type_of(const FakeCamera& camera) {
  return camera.multiplanar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
}

// Of the calls that name the queue: one of the other interface is refused.
inline bool names_another_queue(const FakeCamera& camera, unsigned long request, const void* a) {
  uint32_t type = type_of(camera);
  if (request == VIDIOC_S_FMT) type = static_cast<const v4l2_format*>(a)->type;
  if (request == VIDIOC_REQBUFS) type = static_cast<const v4l2_requestbuffers*>(a)->type;
  if (request == VIDIOC_STREAMON || request == VIDIOC_STREAMOFF) {
    type = static_cast<uint32_t>(*static_cast<const int*>(a));
  }
  if (request == VIDIOC_QUERYBUF || request == VIDIOC_QBUF || request == VIDIOC_DQBUF) {
    type = static_cast<const v4l2_buffer*>(a)->type;
  }
  return type != type_of(camera);
}

inline int fake_ioctl(int fd, unsigned long request, void* argument) {
  FakeCamera& camera = kernel.cameras[fd % 100];
  if (!camera.plugged) return failed(ENODEV);
  if (names_another_queue(camera, request, argument)) return failed(EINVAL);
  switch (request) {
    case VIDIOC_QUERYCAP:
      static_cast<v4l2_capability*>(argument)->capabilities =
          V4L2_CAP_STREAMING |
          (camera.multiplanar ? V4L2_CAP_VIDEO_CAPTURE_MPLANE : V4L2_CAP_VIDEO_CAPTURE);
      return 0;
    case VIDIOC_S_FMT:
      return set_format(camera, *static_cast<v4l2_format*>(argument));
    case VIDIOC_REQBUFS:
      return grant(camera, *static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return query_buffer(camera, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      camera.queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return dequeue(camera, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      if (camera.stalls_for > 0) --camera.stalls_for;
      camera.streaming = true;
      return 0;
    case VIDIOC_STREAMOFF:
      camera.streaming = false;
      camera.queued.clear();
      camera.done.clear();
      return 0;
    case VIDIOC_SUBSCRIBE_EVENT:
      return camera.has_frame_sync ? 0 : failed(EINVAL);
    case VIDIOC_DQEVENT:
      return take(camera.events, argument, ENOENT);
    case VIDIOC_QUERYCTRL:
      return query_control(camera, *static_cast<v4l2_queryctrl*>(argument));
    case VIDIOC_G_CTRL:
      return get_control(camera, *static_cast<v4l2_control*>(argument));
    case VIDIOC_S_CTRL:
      return set_control(camera, *static_cast<v4l2_control*>(argument));
    case VIDIOC_G_EXT_CTRLS:
      return get_pixel_rate(camera, *static_cast<v4l2_ext_controls*>(argument));
    case VIDIOC_SUBDEV_G_FMT:
      static_cast<v4l2_subdev_format*>(argument)->format.width = camera.sensor_width;
      return camera.sensor_width > 0 ? 0 : failed(ENOTTY);
    default:
      return failed(ENOTTY);
  }
}

inline void* fake_map(size_t size, int fd, int64_t offset) {
  if (fd < 0) return std::malloc(size);
  return kernel.cameras[fd - 100].memory[size_t(offset)].data();
}

inline int fake_unmap(void* at, size_t size) {
  if (size == V4l2Node::kBuffers * kBytes) std::free(at);  // not a camera's
  return 0;
}

inline constexpr SystemCalls kFake = {fake_open, fake_close, fake_ioctl, fake_map, fake_unmap};

inline const DeviceNews kNews = {nullptr, [](void*, const char* device, const char* what) {
                                   kernel.told.push_back(std::string(device) + ": " + what);
                                 }};

inline V4l2Setup setup_of(int c) {
  V4l2Setup setup;
  setup.path = c == 0 ? "/dev/video0" : "/dev/video1";
  setup.width = kWidth;
  setup.height = kHeight;
  return setup;
}

}  // namespace pirvs::bsp
