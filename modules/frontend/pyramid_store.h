// One camera's image pyramid in static memory: level 0 is the equalized image, level l has half the
// size of level l - 1, and pixel (x, y) of level l lies at (2 x, 2 y) of level l - 1.
// Cost    twice kImagePixelsMax bytes; build() ~0.25 ms for 752 x 480, x86-64.
// Source  PIRVS paper, section IV.A (equalization); Burt, Adelson, 1983 (pyramid).
#pragma once

#include "core/base/limits.h"
#include "core/kernels/image.h"

namespace pirvs {

class PyramidStore {
 public:
  static constexpr int kLevels = 5;
  void build(const ImageView& image, int levels);
  const ImageView& level(int l) const { return level_[l]; }
  int levels() const { return levels_; }

 private:
  static constexpr int kAlign = 64;
  // All levels have the stride of the first, at most kAlign - 1 more than the width. Their rows,
  // halves rounded up, are at most 2 h + kLevels.
  static constexpr int kBytes =
      2 * kImagePixelsMax + kLevels * kImageSideMax + (kAlign - 1) * (2 * kImageSideMax + kLevels);
  int levels_ = 0;
  ImageView level_[kLevels] = {};
  alignas(64) uint8_t data_[kBytes];
};

}  // namespace pirvs
