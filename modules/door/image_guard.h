// Tells images that a camera has just taken from those that a fault has made.
// In      Each frame in order; the calibration's cameras for their size.
// Out     present without the images that are late, of the wrong size, or frozen: byte for byte
//         the camera's last one. A flat image (black, white) is no fault: it says how dark it is.
// Errors  What is left out is counted by name.
// Cost    reads every 16th row: ~3 us an image of 752 x 480 (x86-64).
// Source  Sensor noise never repeats; FNV-1a over 64-bit words as the checksum.
#pragma once

#include "bsp/api/camera.h"
#include "core/base/limits.h"
#include "core/camera/camera.h"
#include "modules/door/door_loss.h"
#include "modules/door/door_params.h"

namespace pirvs {

class ImageGuard {
 public:
  void configure(const Camera* cameras, int count, const DoorParams& params);
  void check(StereoFrame& frame, DoorLosses& losses);

 private:
  bool is_good(const StereoFrame& frame, int c, DoorLosses& losses);

  int count_ = 0;  // cameras that there are: others cannot be missing
  int width_[kCamerasMax] = {}, height_[kCamerasMax] = {};
  TimeNs pair_ = 0;
  uint64_t sum_[kCamerasMax] = {};  // of the last image; 0: none, or a flat one
};

}  // namespace pirvs
