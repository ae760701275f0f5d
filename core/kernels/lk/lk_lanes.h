// Bilinear samples of a window, sixteen at a time. Private to core/kernels/lk.
#pragma once

#include "core/kernels/lanes16.h"
#include "core/kernels/lk/lk.h"
#include "core/kernels/lk/lk_steps.h"

namespace pirvs::lk {

using neon::Int16x16;
static_assert(kLkSize == 16, "one Int16x16 per row");

struct Weights {
  Int16x16 left, right, lower;
};

inline Weights weights(const Window& w) {
  return {neon::fill(static_cast<int16_t>(128 - w.wx)), neon::fill(static_cast<int16_t>(w.wx)),
          neon::fill(static_cast<int16_t>(w.wy))};
}

// Sixteen horizontal blends, grey * 128: at most 255 * 128 = 32640, so int16. Reads 17 bytes.
inline Int16x16 blend_row(const uint8_t* p, const Weights& w) {
  return neon::blend_bytes(p, w.left, p + 1, w.right);
}

// grey * 32. |lower - upper| <= 32640 and the weight is below one, so the blend lies between both
// rows; 2 more than 32640 still fits int16.
inline Int16x16 blend_rows(Int16x16 upper, Int16x16 lower, const Weights& w) {
  const Int16x16 change = neon::multiply_q15(neon::subtract(lower, upper), w.lower);
  return neon::shift_right_rounded<2>(neon::add(upper, change));
}

// |next - last| <= 8160, and 4 more, fits int16; the result is within +-1020.
inline Int16x16 gradient(const int16_t* last, const int16_t* next) {
  const Int16x16 change = neon::subtract(neon::load(next), neon::load(last));
  return neon::shift_right_rounded<3>(change);
}

}  // namespace pirvs::lk
