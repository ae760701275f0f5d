// The stereo camera: pairs of images in the order of their stamps.
// In      Poll; release the frame before polling the next.
// Out     The oldest frame not yet polled. Its images stay valid until camera_release().
//         t: middle of the exposure, on the clock of now(). present: bit c says camera c
//         delivered; the view of a missing image is empty. late: how much older than t that
//         camera's image is, 0 for a pair of one trigger; a driver that cannot pair says so here.
// Frames  image[c] is camera c, distorted pixels, (0,0) = centre of the first pixel.
// Errors  kEmpty: nothing now. kStale: the stream has ended. kTimeout, kBusFault, kBadData: the
//         device's fault, and out is undefined.
// Cost    No copy; a poll never waits.
// Source  DESIGN, "One way for the data".
#pragma once

#include <cstdint>

#include "core/base/status.h"
#include "core/base/time.h"
#include "core/kernels/image.h"

namespace pirvs {

struct StereoFrame {
  TimeNs t = 0;
  ImageView image[2];
  uint8_t present = 0;
  TimeNs late[2] = {0, 0};
};

namespace bsp {

Status camera_poll(StereoFrame& out);
void camera_release();

}  // namespace bsp
}  // namespace pirvs
