#include "modules/frontend/pyramid_store.h"

#include "core/base/assert.h"
#include "core/kernels/equalize/equalize.h"
#include "core/kernels/pyramid/pyramid.h"

namespace pirvs {

void PyramidStore::build(const ImageView& image, int levels) {
  PIRVS_ASSERT(image.width <= kImageWidthMax && image.height <= kImageHeightMax);
  PIRVS_ASSERT(levels >= 1 && levels <= kLevels);
  levels_ = levels;
  uint8_t* at = data_;
  equalize(image, at, kStride);
  level_[0] = {at, image.width, image.height, kStride};
  for (int l = 1; l < levels; ++l) {
    const ImageView& above = level_[l - 1];
    at += above.height * kStride;
    pyramid_down(above, at, kStride);
    level_[l] = {at, (above.width + 1) / 2, (above.height + 1) / 2, kStride};
  }
}

}  // namespace pirvs
