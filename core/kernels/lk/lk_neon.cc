#include "core/kernels/lk/lk.h"
#include "core/kernels/lk/lk_steps.h"
#include "core/kernels/neon.h"

namespace pirvs {
namespace {

using lk::kPixels;

struct Weights {
  uint16x8_t left, right;
  int16x8_t lower;
};

Weights weights(const lk::Window& w) {
  return {vdupq_n_u16(static_cast<uint16_t>(128 - w.wx)), vdupq_n_u16(static_cast<uint16_t>(w.wx)),
          vdupq_n_s16(static_cast<int16_t>(w.wy))};
}

struct Row {
  int16x8_t low, high;
};

// Eight horizontal blends, grey * 128: at most 255 * 128 = 32640, so int16. Reads 9 bytes.
inline int16x8_t blend_half_row(const uint8_t* p, const Weights& w) {
  return vreinterpretq_s16_u16(neon::blend_bytes(p, w.left, p + 1, w.right));
}

// Sixteen of them. Reads 17 bytes.
inline Row blend_row(const uint8_t* p, const Weights& w) {
  return {blend_half_row(p, w), blend_half_row(p + 8, w)};
}

// grey * 32. |lower - upper| <= 32640 and the weight is below one, so the blend
// lies between both rows; 2 more than 32640 still fits int16.
inline int16x8_t blend_rows(int16x8_t upper, int16x8_t lower, const Weights& w) {
  const int16x8_t blended = vaddq_s16(upper, neon::multiply_q15(vsubq_s16(lower, upper), w.lower));
  return vshrq_n_s16(vaddq_s16(blended, vdupq_n_s16(2)), 2);
}

struct Neon {
  // d_gx: 256 * 8160 * 1020 = 2,130,739,200 < 2^31 over all lanes, so any grouping is exact.
  static lk::DifferenceSums difference(const lk::Window& window, const LkPatch& patch, int16_t* d) {
    const Weights w = weights(window);
    const int16x8_t ones = vdupq_n_s16(1);
    int32x4_t sum = vdupq_n_s32(0), sum_gx = sum, sum_gy = sum;
    const uint8_t* p = window.first;
    Row upper = blend_row(p, w);
    for (int i = 0; i < kPixels; i += kLkSize) {
      p += window.stride;
      const Row lower = blend_row(p, w);
      const int16x8_t low = vsubq_s16(blend_rows(upper.low, lower.low, w), vld1q_s16(patch.t + i));
      const int16x8_t high =
          vsubq_s16(blend_rows(upper.high, lower.high, w), vld1q_s16(patch.t + i + 8));
      vst1q_s16(d + i, low);
      vst1q_s16(d + i + 8, high);
      // |low + high| <= 2 * 8160 fits int16.
      sum = neon::add_products(sum, vaddq_s16(low, high), ones);
      sum_gx = neon::add_products(sum_gx, low, vld1q_s16(patch.gx + i));
      sum_gx = neon::add_products(sum_gx, high, vld1q_s16(patch.gx + i + 8));
      sum_gy = neon::add_products(sum_gy, low, vld1q_s16(patch.gy + i));
      sum_gy = neon::add_products(sum_gy, high, vld1q_s16(patch.gy + i + 8));
      upper = lower;
    }
    return {neon::sum_lanes(sum), neon::sum_lanes(sum_gx), neon::sum_lanes(sum_gy)};
  }

  // |d - mean| <= 2 * 8160 fits int16; the sum of 256 of them fits int32.
  static int32_t sum_abs(const int16_t* d, int16_t mean) {
    const int16x8_t offset = vdupq_n_s16(mean), ones = vdupq_n_s16(1);
    int32x4_t sum = vdupq_n_s32(0);
    for (int i = 0; i < kPixels; i += 8)
      sum = neon::add_products(sum, vabsq_s16(vsubq_s16(vld1q_s16(d + i), offset)), ones);
    return neon::sum_lanes(sum);
  }
};

constexpr int kBordered = kLkSize + 2;
constexpr int kBorderedStride = 24;  // int16, keeps rows on 16 bytes

// All 18 x 18 samples. The last eight columns start at 10 and repeat some, so that exactly the
// 19 bytes of the window are read in each row.
void sample_bordered(const lk::Window& window, int16_t* out) {
  const Weights w = weights(window);
  constexpr int kLast = kBordered - 8;
  const uint8_t* p = window.first;
  Row upper = blend_row(p, w);
  int16x8_t upper_last = blend_half_row(p + kLast, w);
  for (int y = 0; y < kBordered; ++y, out += kBorderedStride) {
    p += window.stride;
    const Row lower = blend_row(p, w);
    const int16x8_t lower_last = blend_half_row(p + kLast, w);
    vst1q_s16(out, blend_rows(upper.low, lower.low, w));
    vst1q_s16(out + 8, blend_rows(upper.high, lower.high, w));
    vst1q_s16(out + kLast, blend_rows(upper_last, lower_last, w));
    upper = lower;
    upper_last = lower_last;
  }
}

// |next - last| <= 8160, and 4 more, fits int16; the result is within +-1020.
inline int16x8_t gradient(const int16_t* last, const int16_t* next) {
  const int16x8_t difference = vsubq_s16(vld1q_s16(next), vld1q_s16(last));
  return vshrq_n_s16(vaddq_s16(difference, vdupq_n_s16(4)), 3);
}

}  // namespace

bool lk_extract_neon(const ImageView& im, float x, float y, LkPatch& out) {
  lk::Window window;
  if (!lk::place(im, x, y, 1, window)) return false;
  alignas(16) int16_t samples[kBordered * kBorderedStride];
  sample_bordered(window, samples);
  const int16x8_t ones = vdupq_n_s16(1);
  int32x4_t sx = vdupq_n_s32(0), sy = sx, sxx = sx, sxy = sx, syy = sx;  // 256 * 1020^2 < 2^31
  for (int i = 0; i < kPixels; i += 8) {
    const int16_t* p = samples + (i / kLkSize + 1) * kBorderedStride + 1 + i % kLkSize;
    const int16x8_t gx = gradient(p - 1, p + 1);
    const int16x8_t gy = gradient(p - kBorderedStride, p + kBorderedStride);
    vst1q_s16(out.t + i, vld1q_s16(p));
    vst1q_s16(out.gx + i, gx);
    vst1q_s16(out.gy + i, gy);
    sx = neon::add_products(sx, gx, ones);
    sy = neon::add_products(sy, gy, ones);
    sxx = neon::add_products(sxx, gx, gx);
    sxy = neon::add_products(sxy, gx, gy);
    syy = neon::add_products(syy, gy, gy);
  }
  lk::finish({neon::sum_lanes(sx), neon::sum_lanes(sy), neon::sum_lanes(sxx), neon::sum_lanes(sxy),
              neon::sum_lanes(syy)},
             window, x, y, out);
  return true;
}

bool lk_align_neon(const ImageView& im, const LkPatch& patch, float& x, float& y,
                   int iterations_max, float step_min_px, float& residual_grey) {
  return lk::align<Neon>(im, patch, x, y, iterations_max, step_min_px, residual_grey);
}

}  // namespace pirvs
