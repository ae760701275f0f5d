#include "core/kernels/lk/deform.h"
#include "core/kernels/lk/deform_steps.h"
#include "core/kernels/lk/lk_lanes.h"

namespace pirvs {
namespace {

using deforming::kBordered;
using deforming::kBorderedStride;
using deforming::kN;
using lk::kPixels;
using neon::Int16x16;

// Twice the offset from the patch's centre.
alignas(32) constexpr int16_t kColumns[kLkSize] = {-15, -13, -11, -9, -7, -5, -3, -1,
                                                   1,   3,   5,   7,  9,  11, 13, 15};

// The derivatives along one row. 1020 * 15, and 8 more, fits int16.
struct Derivatives {
  Int16x16 j[kN];
};

Derivatives derivatives(const LkPatch& patch, Int16x16 mean, int row) {
  const auto times = [](Int16x16 a, Int16x16 offset) {
    return neon::shift_right_rounded<4>(neon::multiply(a, offset));
  };
  const int i = row * kLkSize;
  const Int16x16 u = neon::load(kColumns), v = neon::fill(static_cast<int16_t>(2 * row - 15));
  const Int16x16 gx = neon::load(patch.gx + i), gy = neon::load(patch.gy + i);
  const Int16x16 over_mean = neon::subtract(neon::load(patch.t + i), mean);
  return {{gx, gy, times(gx, u), times(gx, v), times(gy, u), times(gy, v),
           neon::shift_right_rounded<3>(over_mean)}};
}

struct Neon {
  // |4 (sample - mean)| <= 32640 and below twice 8160 after it: all fits int16.
  static void contrast(int16_t* samples, int16_t mean, int16_t q13) {
    const Int16x16 middle = neon::fill(mean), factor = neon::fill(q13);
    const Int16x16 black = neon::fill(0), white = neon::fill(8160);
    const auto change = [&](int16_t* p) {
      const Int16x16 over = neon::subtract(neon::load(p), middle);
      const Int16x16 twice = neon::add(over, over);
      const Int16x16 scaled = neon::multiply_q15(neon::add(twice, twice), factor);
      return neon::smaller(neon::larger(neon::add(middle, scaled), black), white);
    };
    for (int row = 0; row < kBordered; ++row, samples += kBorderedStride) {
      const Int16x16 begin = change(samples), end = change(samples + kBordered - kLkSize);
      neon::store(samples, begin);
      neon::store(samples + kBordered - kLkSize, end);
    }
  }

  static deforming::Products products(const int16_t* samples, LkPatch& out) {
    neon::ProductSum sum;
    for (int i = 0; i < kPixels; i += kLkSize) {
      const int16_t* p = samples + (i / kLkSize + 1) * kBorderedStride + 1;
      const Int16x16 t = neon::load(p);
      neon::store(out.t + i, t);
      neon::store(out.gx + i, lk::gradient(p - 1, p + 1));
      neon::store(out.gy + i, lk::gradient(p - kBorderedStride, p + kBorderedStride));
      sum.add(t);
    }
    deforming::Products result;
    result.mean = static_cast<int16_t>((sum.total() + kPixels / 2) >> 8);
    neon::ProductSum sums[kN], products[kN * (kN + 1) / 2];
    const Int16x16 mean = neon::fill(result.mean);
    for (int row = 0; row < kLkSize; ++row) {
      const Derivatives d = derivatives(out, mean, row);
      for (int a = 0, at = 0; a < kN; ++a) {
        sums[a].add(d.j[a]);
        for (int b = 0; b <= a; ++b, ++at) products[at].add_products(d.j[a], d.j[b]);
      }
    }
    for (int a = 0; a < kN; ++a) result.sums[a] = sums[a].total();
    for (int at = 0; at < kN * (kN + 1) / 2; ++at) result.products[at] = products[at].total();
    return result;
  }

  static deforming::Differences differences(const lk::Window& window, const DeformedPatch& patch) {
    const lk::Weights w = lk::weights(window);
    const Int16x16 mean = neon::fill(patch.mean);
    neon::ProductSum sum, products[kN];
    const uint8_t* p = window.first;
    Int16x16 upper = lk::blend_row(p, w);
    for (int row = 0; row < kLkSize; ++row) {
      p += window.stride;
      const Int16x16 lower = lk::blend_row(p, w);
      const Int16x16 image = lk::blend_rows(upper, lower, w);
      const Int16x16 d = neon::subtract(image, neon::load(patch.lk.t + row * kLkSize));
      const Derivatives j = derivatives(patch.lk, mean, row);
      sum.add(d);
      for (int a = 0; a < kN; ++a) products[a].add_products(d, j.j[a]);
      upper = lower;
    }
    deforming::Differences result;
    result.d = sum.total();
    for (int a = 0; a < kN; ++a) result.products[a] = products[a].total();
    return result;
  }
};

}  // namespace

bool deform_neon(const KeyPatch& key, const Deformation& d, float damping, DeformedPatch& out) {
  return deforming::deform<Neon>(key, d, damping, out);
}

bool deform_step_neon(const ImageView& im, const DeformedPatch& patch, float& x, float& y,
                      Deformation& d) {
  return deforming::step<Neon>(im, patch, x, y, d);
}

}  // namespace pirvs
