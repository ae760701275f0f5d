#include "core/kernels/lk/lk.h"
#include "core/kernels/lk/lk_lanes.h"

namespace pirvs {
namespace {

using lk::blend_row;
using lk::blend_rows;
using lk::gradient;
using lk::kPixels;
using lk::Weights;
using neon::Int16x16;

struct Neon {
  // d_gx: 256 * 8160 * 1020 = 2,130,739,200 < 2^31 over all lanes, so any grouping is exact.
  static lk::DifferenceSums difference(const lk::Window& window, const LkPatch& patch, int16_t* d) {
    const Weights w = weights(window);
    neon::ProductSum sum, sum_gx, sum_gy;
    const uint8_t* p = window.first;
    Int16x16 upper = blend_row(p, w);
    for (int i = 0; i < kPixels; i += kLkSize) {
      p += window.stride;
      const Int16x16 lower = blend_row(p, w);
      const Int16x16 row = neon::subtract(blend_rows(upper, lower, w), neon::load(patch.t + i));
      neon::store(d + i, row);
      sum.add(row);
      sum_gx.add_products(row, neon::load(patch.gx + i));
      sum_gy.add_products(row, neon::load(patch.gy + i));
      upper = lower;
    }
    return {sum.total(), sum_gx.total(), sum_gy.total()};
  }

  // |d - mean| <= 2 * 8160 fits int16; the sum of 256 of them fits int32.
  static int32_t sum_abs(const int16_t* d, int16_t mean) {
    const Int16x16 offset = neon::fill(mean);
    neon::ProductSum sum;
    for (int i = 0; i < kPixels; i += kLkSize)
      sum.add(neon::absolute(neon::subtract(neon::load(d + i), offset)));
    return sum.total();
  }
};

constexpr int kBordered = kLkSize + 2;
constexpr int kBorderedStride = 32;  // int16, keeps rows on a cache line

// All 18 x 18 samples. Each row is done from column 0 and again from column 2, so that exactly the
// 19 bytes of the window are read.
void sample_bordered(const lk::Window& window, int16_t* out) {
  const Weights w = weights(window);
  const uint8_t* p = window.first;
  Int16x16 upper = blend_row(p, w), upper_end = blend_row(p + 2, w);
  for (int y = 0; y < kBordered; ++y, out += kBorderedStride) {
    p += window.stride;
    const Int16x16 lower = blend_row(p, w), lower_end = blend_row(p + 2, w);
    neon::store(out, blend_rows(upper, lower, w));
    neon::store(out + 2, blend_rows(upper_end, lower_end, w));
    upper = lower;
    upper_end = lower_end;
  }
}

}  // namespace

bool lk_extract_neon(const ImageView& im, float x, float y, LkPatch& out) {
  lk::Window window;
  if (!lk::place(im, x, y, 1, window)) return false;
  alignas(64) int16_t samples[kBordered * kBorderedStride];
  sample_bordered(window, samples);
  neon::ProductSum sx, sy, sxx, sxy, syy;  // 256 * 1020^2 < 2^31
  for (int i = 0; i < kPixels; i += kLkSize) {
    const int16_t* p = samples + (i / kLkSize + 1) * kBorderedStride + 1;
    const Int16x16 gx = gradient(p - 1, p + 1);
    const Int16x16 gy = gradient(p - kBorderedStride, p + kBorderedStride);
    neon::store(out.t + i, neon::load(p));
    neon::store(out.gx + i, gx);
    neon::store(out.gy + i, gy);
    sx.add(gx);
    sy.add(gy);
    sxx.add_products(gx, gx);
    sxy.add_products(gx, gy);
    syy.add_products(gy, gy);
  }
  lk::finish({sx.total(), sy.total(), sxx.total(), sxy.total(), syy.total()}, window, x, y, out);
  return true;
}

bool lk_align_neon(const ImageView& im, const LkPatch& patch, float& x, float& y,
                   int iterations_max, float step_min_px, float& residual_grey) {
  return lk::align<Neon>(im, patch, x, y, iterations_max, step_min_px, residual_grey);
}

}  // namespace pirvs
