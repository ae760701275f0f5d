// The largest sensor set that the static memory is laid out for. How large an image may be is the
// board's word: board_limits.h lies in board/<name>, or in board/bare for all boards without an
// operating system.
// Errors  none; what exceeds a limit is rejected where it enters (calibration, sensor door).
// Cost    Image pools grow with pixels x cameras.
#pragma once

#include "board_limits.h"  // kImagePixelsMax, kImageSideMax, kPoolBytesMax

namespace pirvs {

inline constexpr int kCamerasMax = 2;

static_assert(kImageSideMax <= kImagePixelsMax && kImagePixelsMax <= kImageSideMax * kImageSideMax);

// An image of any shape is held, upright or on its side, if its pixels and its longer side fit.
constexpr bool image_fits(int width, int height) {
  return width > 0 && height > 0 && width <= kImageSideMax && height <= kImageSideMax &&
         width * height <= kImagePixelsMax;
}

}  // namespace pirvs
