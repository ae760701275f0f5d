// What both variants of deform share: where to sample the key patch, and the few float operations
// after the sums. Private to core/kernels/lk.
#pragma once

#include <cmath>

#include "core/kernels/lk/deform.h"
#include "core/kernels/lk/lk_steps.h"

namespace pirvs::deforming {

inline constexpr int kN = kDeformUnknowns;
inline constexpr int kBordered = kLkSize + 2;  // a template and its neighbours
inline constexpr int kBorderedStride = 32;     // int16, keeps rows on a cache line
inline constexpr float kStepMax_px = 0.5f;     // lk_align has converged: more is another place

// The key patch on a sheared grid: positions in 1/65536 px, exact sums of integers.
struct Grid {
  int32_t x, y;            // of the first sample
  int32_t xx, xy, yx, yy;  // x and y move by xx and yx a column, by xy and yy a row
};

inline float determinant(const Deformation& d) { return d.xx * d.yy - d.xy * d.yx; }

// false: the grid leaves the key patch.
inline bool place(const KeyPatch& key, const Deformation& d, Grid& out) {
  constexpr float kOne = 65536.0f, kRadius_px = 0.5f * (kBordered - 1);
  const float scale = 1.0f / determinant(d);
  const float xx = d.yy * scale, xy = -d.xy * scale, yx = -d.yx * scale, yy = d.xx * scale;
  out.x = static_cast<int32_t>((key.x - kRadius_px * (xx + xy)) * kOne);
  out.y = static_cast<int32_t>((key.y - kRadius_px * (yx + yy)) * kOne);
  out.xx = static_cast<int32_t>(xx * kOne);
  out.xy = static_cast<int32_t>(xy * kOne);
  out.yx = static_cast<int32_t>(yx * kOne);
  out.yy = static_cast<int32_t>(yy * kOne);
  constexpr int32_t kLast = kBordered - 1, kEnd = (kKeySide - 1) << 16;
  for (int corner = 0; corner < 4; ++corner) {  // all other samples lie between them
    const int32_t column = corner % 2 * kLast, row = corner / 2 * kLast;
    const int32_t x = out.x + column * out.xx + row * out.xy;
    const int32_t y = out.y + column * out.yx + row * out.yy;
    if (!(x >= 0 && x < kEnd && y >= 0 && y < kEnd)) return false;
  }
  return true;
}

// All 18 x 18 samples, grey * 32, bilinear in 1/128 px. Returns their sum. There is no gather on
// NEON, so both variants do it one by one.
inline int32_t sample_grid(const KeyPatch& key, const Grid& grid, int16_t* out) {
  int32_t sum = 0;
  for (int row = 0; row < kBordered; ++row, out += kBorderedStride) {
    int32_t x = grid.x + row * grid.xy, y = grid.y + row * grid.yy;
    for (int column = 0; column < kBordered; ++column, x += grid.xx, y += grid.yx) {
      const uint8_t* p = key.grey + (y >> 16) * kKeySide + (x >> 16);
      const int wx = x >> 9 & 127, wy = y >> 9 & 127;
      const int upper = p[0] * (128 - wx) + p[1] * wx;
      const int lower = p[kKeySide] * (128 - wx) + p[kKeySide + 1] * wx;
      const int value = (upper * (128 - wy) + lower * wy + 256) >> 9;
      out[column] = static_cast<int16_t>(value);
      sum += value;
    }
  }
  return sum;
}

inline int16_t mean_of_grid(int32_t sum) {
  return static_cast<int16_t>(sum / (kBordered * kBordered));
}

// 1/8192, below 2 by deform_usable().
inline int16_t contrast_q13(const Deformation& d) {
  return static_cast<int16_t>(d.contrast * 8192.0f);
}

// Sums over the template of its derivatives and of their products, in units of 1/8 grey a px; the
// lower triangle row by row. The derivatives, all within +-1020: gx, gy, then both times the offset
// in x and in y over 8 px (gx u, gx v, gy u, gy v), then the grey over its mean by 8.
// 256 * 1020^2 < 2^31.
struct Products {
  int16_t mean;  // of the template, grey * 32
  int32_t sums[kN];
  int32_t products[kN * (kN + 1) / 2];
};

inline float scaled_covariance(int64_t products, int64_t sum_a, int64_t sum_b, float scale) {
  return static_cast<float>(lk::kPixels * products - sum_a * sum_b) * scale;
}

// The normal equations, factored. false: they have no solution, which damping excludes.
inline bool factor(const Products& p, float damping, float* L) {
  constexpr float kScale = 1.0f / (lk::kPixels * lk::kPixels * 8.0f * 8.0f);
  for (int i = 0, at = 0; i < kN; ++i) {
    for (int j = 0; j <= i; ++j, ++at) {
      float h = scaled_covariance(p.products[at], p.sums[i], p.sums[j], kScale);
      if (i == j && i >= 2) h += damping;
      for (int k = 0; k < j; ++k) h -= L[i * kN + k] * L[j * kN + k];
      if (i != j) {
        L[i * kN + j] = h / L[j * kN + j];
      } else {
        if (!(h > 0.0f)) return false;
        L[i * kN + i] = std::sqrt(h);
      }
    }
  }
  return true;
}

// d = image - template, grey * 32, and its products with the derivatives.
struct Differences {
  int32_t d;
  int32_t products[kN];  // 256 * 8160 * 1020 < 2^31
};

inline bool finish_step(const DeformedPatch& patch, const lk::Window& at, const Differences& sums,
                        float& x, float& y, Deformation& d) {
  constexpr float kScale = 1.0f / (lk::kPixels * lk::kPixels * 32.0f * 8.0f);
  const float* L = patch.factors;
  float step[kN];
  for (int i = 0; i < kN; ++i) {
    float b = scaled_covariance(sums.products[i], sums.d, patch.sums[i], kScale);
    for (int k = 0; k < i; ++k) b -= L[i * kN + k] * step[k];
    step[i] = b / L[i * kN + i];
  }
  for (int i = kN; i-- > 0;) {
    for (int k = i + 1; k < kN; ++k) step[i] -= L[k * kN + i] * step[k];
    step[i] /= L[i * kN + i];
  }
  if (!(std::fabs(step[0]) < kStepMax_px && std::fabs(step[1]) < kStepMax_px)) return false;
  // The derivatives are by offsets in units of 8 px, and by contrast in units of 1/2.
  Deformation undo{1 + step[2] * 0.125f, step[3] * 0.125f, step[4] * 0.125f, 1 + step[5] * 0.125f,
                   1};
  const float scale = 1.0f / determinant(undo);
  const Deformation next{
      (undo.yy * d.xx - undo.xy * d.yx) * scale, (undo.yy * d.xy - undo.xy * d.yy) * scale,
      (undo.xx * d.yx - undo.yx * d.xx) * scale, (undo.xx * d.yy - undo.yx * d.xy) * scale,
      d.contrast * (1 + 0.5f * step[6])};
  if (!deform_usable(next)) return false;
  d = next;
  x = at.x - step[0];
  y = at.y - step[1];
  return true;
}

// Variant has: static void contrast(int16_t* samples, int16_t mean, int16_t q13)
//              static Products products(const int16_t* samples, LkPatch& out)
template <class Variant>
bool deform(const KeyPatch& key, const Deformation& d, float damping, DeformedPatch& out) {
  Grid grid;
  if (!deform_usable(d) || !place(key, d, grid)) return false;
  alignas(64) int16_t samples[kBordered * kBorderedStride];
  const int32_t sum = sample_grid(key, grid, samples);
  Variant::contrast(samples, mean_of_grid(sum), contrast_q13(d));
  const Products p = Variant::products(samples, out.lk);
  out.mean = p.mean;
  for (int i = 0; i < kN; ++i) out.sums[i] = p.sums[i];
  const lk::Window exact{nullptr, 0, 0, 0, 0, 0};
  lk::finish({p.sums[0], p.sums[1], p.products[0], p.products[1], p.products[2]}, exact, 0, 0,
             out.lk);
  out.deformation = d;
  return out.lk.usable && factor(p, damping, out.factors);
}

// Variant has: static Differences differences(const lk::Window&, const DeformedPatch&)
template <class Variant>
bool step(const ImageView& im, const DeformedPatch& patch, float& x, float& y, Deformation& d) {
  lk::Window window;
  if (!lk::place(im, x, y, 0, window)) return false;
  return finish_step(patch, window, Variant::differences(window, patch), x, y, d);
}

}  // namespace pirvs::deforming
