// The stereo camera: pairs of images in the order of their stamps, lent and not copied.
// In      camera_poll: from one core. A frame polled has one holder; each camera_retain() adds one,
//         each camera_release() takes one away, in any order and from any core.
// Out     The oldest frame not yet polled; its images stay valid until its last holder releases it.
//         t: middle of the exposure, on the clock of now(). present: bit c says camera c
//         delivered; the view of a missing image is empty. late: how much older than t that
//         camera's image is, 0 for a pair of one trigger; a driver that cannot pair says so here.
//         lost_before: frames that the sensor took and nobody will see, since the last one polled.
// Frames  image[c] is camera c, distorted pixels, (0,0) = centre of the first pixel.
// Errors  camera_poll: kEmpty: nothing now. kStale: the stream has ended. kTimeout, kBusFault,
//         kBadData: the device's fault, and out is undefined. While kFramesLentMax frames are held
//         a live camera loses what comes; a replay waits. A frame that is not held, retained or
//         released, is a bug and asserts.
//         camera_range, camera_control: kNotFound: these cameras cannot be told. kEmpty: there is
//         none now, ask again later. camera_control: kBadData: out of their range.
// Cost    No copy; a poll never waits. retain, release: ~10 ns, but for the last release, which may
//         cost a system call.
// Source  docs/architecture.md; V4L2 streaming I/O, buffers that are dequeued and queued again.
#pragma once

#include <cstdint>

#include "core/base/limits.h"
#include "core/base/status.h"
#include "core/base/time.h"
#include "core/kernels/image.h"
#include "core/store/handle.h"

namespace pirvs {

struct StereoFrame;
using FrameId = Handle<StereoFrame>;

// What the camera tells of an image; 0: it does not.
struct ImageInfo {
  TimeNs exposure_ns = 0;
  float gain = 0;         // as a factor
  uint32_t sequence = 0;  // the camera's own count of images
};

struct StereoFrame {
  TimeNs t = 0;
  FrameId id;
  ImageView image[kCamerasMax];
  ImageInfo info[kCamerasMax];
  uint8_t present = 0;
  TimeNs late[kCamerasMax] = {};
  uint32_t lost_before = 0;
};

// From the next frame on, of all cameras; 0: the cameras decide themselves.
struct CameraControl {
  TimeNs exposure_ns = 0;
  float gain = 0;
};

// What all of these cameras can be told.
struct CameraRange {
  TimeNs exposure_ns_min = 0, exposure_ns_max = 0, exposure_ns_step = 0;
  float gain_min = 1, gain_max = 1, gain_step = 0;  // 1 to 1: exposure alone
};

namespace bsp {

// A backend can lend at least so many at a time, besides those that it is filling.
inline constexpr int kFramesLentMax = 1     // in the sensor door, until the IMU has come as far
                                      + 1   // in the front-ends and tracking
                                      + 6;  // in the recorder, until they are written

Status camera_poll(StereoFrame& out);
void camera_retain(FrameId id);
void camera_release(FrameId id);
Result<CameraRange> camera_range();
Status camera_control(const CameraControl& control);

}  // namespace bsp
}  // namespace pirvs
