// The mirrored border of both variants. Private to core/kernels/pyramid.
#pragma once

#include "core/base/assert.h"
#include "core/kernels/pyramid/pyramid.h"

namespace pirvs::pyramid_detail {

// Index i, up to two outside 0..count-1, brought inside: -1 is 1, count is count - 2. With one or
// two entries the mirror image leaves on the other side and is mirrored again.
inline int mirror(int i, int count) {
  if (count == 1) return 0;
  while (i < 0 || i >= count) i = i < 0 ? -i : 2 * (count - 1) - i;
  return i;
}

inline void check(const ImageView& in, int out_stride) {
  PIRVS_ASSERT(in.width > 0 && in.height > 0 && in.width <= kPyramidWidthMax);
  PIRVS_ASSERT(out_stride >= (in.width + 1) / 2);
}

}  // namespace pirvs::pyramid_detail
