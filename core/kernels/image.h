// An 8-bit grey image that somebody else owns.
// In      Pointer to the first pixel, size in pixels, bytes from one row to the next.
// Out     row(y): first pixel of row y, 0 <= y < height (not checked).
// Frames  Pixels: x right, y down, (0,0) = centre of the first pixel.
// Errors  none.
// Cost    Passed by const reference; 24 bytes.
// Source  DESIGN, "Frames, units, names".
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs {

struct ImageView {
  const uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;

  const uint8_t* row(int y) const { return data + static_cast<ptrdiff_t>(y) * stride; }
};

}  // namespace pirvs
