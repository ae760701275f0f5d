#include "modules/frontend/pyramid_store.h"

#include "core/base/assert.h"
#include "core/kernels/equalize/equalize.h"
#include "core/kernels/pyramid/pyramid.h"

namespace pirvs {
namespace {

constexpr int kCountEvery = 4;  // rows: a quarter of the pixels has the grey values of all

}  // namespace

void PyramidStore::build(const ImageView& image, int levels) {
  PIRVS_ASSERT(image_fits(image.width, image.height));
  PIRVS_ASSERT(levels >= 1 && levels <= kLevels);
  levels_ = levels;
  const int stride = (image.width + kAlign - 1) / kAlign * kAlign;
  uint8_t* at = data_;
  equalize(image, at, stride, kCountEvery);
  level_[0] = {at, image.width, image.height, stride};
  for (int l = 1; l < levels; ++l) {
    const ImageView& above = level_[l - 1];
    at += above.height * stride;
    pyramid_down(above, at, stride);
    level_[l] = {at, (above.width + 1) / 2, (above.height + 1) / 2, stride};
  }
}

}  // namespace pirvs
