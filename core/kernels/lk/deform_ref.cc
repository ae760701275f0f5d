#include <algorithm>
#include <cmath>

#include "core/kernels/lk/deform.h"
#include "core/kernels/lk/deform_steps.h"

namespace pirvs {
namespace {

using deforming::kBordered;
using deforming::kBorderedStride;
using deforming::kN;
using lk::kPixels;

int16_t over_16(int a) { return static_cast<int16_t>((a + 8) >> 4); }

// The derivatives at pixel i: twice the offset is odd, from -15 to 15.
void derivatives(const LkPatch& patch, int16_t mean, int i, int16_t* out) {
  const int gx = patch.gx[i], gy = patch.gy[i];
  const int u = 2 * (i % kLkSize) - 15, v = 2 * (i / kLkSize) - 15;
  const int16_t all[kN] = {patch.gx[i],
                           patch.gy[i],
                           over_16(gx * u),
                           over_16(gx * v),
                           over_16(gy * u),
                           over_16(gy * v),
                           int16_t((patch.t[i] - mean + 4) >> 3)};
  std::copy(all, all + kN, out);
}

struct Reference {
  static void contrast(int16_t* samples, int16_t mean, int16_t q13) {
    for (int i = 0; i < kBordered * kBorderedStride; ++i) {
      if (i % kBorderedStride >= kBordered) continue;
      const int change = (2 * (4 * (samples[i] - mean)) * q13 + 32768) >> 16;
      samples[i] = static_cast<int16_t>(std::clamp(mean + change, 0, 8160));
    }
  }

  static deforming::Products products(const int16_t* samples, LkPatch& out) {
    int32_t sum = 0;
    for (int i = 0; i < kPixels; ++i) {
      const int16_t* p = samples + (i / kLkSize + 1) * kBorderedStride + i % kLkSize + 1;
      out.t[i] = *p;
      out.gx[i] = static_cast<int16_t>((p[1] - p[-1] + 4) >> 3);
      out.gy[i] = static_cast<int16_t>((p[kBorderedStride] - p[-kBorderedStride] + 4) >> 3);
      sum += *p;
    }
    deforming::Products result = {};
    result.mean = static_cast<int16_t>((sum + kPixels / 2) >> 8);
    for (int i = 0; i < kPixels; ++i) {
      int16_t j[kN];
      derivatives(out, result.mean, i, j);
      for (int a = 0, at = 0; a < kN; ++a) {
        result.sums[a] += j[a];
        for (int b = 0; b <= a; ++b, ++at) result.products[at] += j[a] * j[b];
      }
    }
    return result;
  }

  static deforming::Differences differences(const lk::Window& window, const DeformedPatch& patch) {
    deforming::Differences sums = {};
    for (int i = 0; i < kPixels; ++i) {
      const int d = lk::sample(window, i % kLkSize, i / kLkSize) - patch.lk.t[i];
      int16_t j[kN];
      derivatives(patch.lk, patch.mean, i, j);
      sums.d += d;
      for (int a = 0; a < kN; ++a) sums.products[a] += d * j[a];
    }
    return sums;
  }
};

}  // namespace

bool key_patch(const ImageView& im, float x, float y, KeyPatch& out) {
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(im.width) && y < static_cast<float>(im.height)))
    return false;
  const int left = static_cast<int>(x) - kKeySide / 2, top = static_cast<int>(y) - kKeySide / 2;
  for (int row = 0; row < kKeySide; ++row) {
    const uint8_t* from = im.row(std::clamp(top + row, 0, im.height - 1));
    for (int column = 0; column < kKeySide; ++column) {
      out.grey[row * kKeySide + column] = from[std::clamp(left + column, 0, im.width - 1)];
    }
  }
  out.x = x - static_cast<float>(left);
  out.y = y - static_cast<float>(top);
  return true;
}

bool deform_usable(const Deformation& d) {
  const float area = deforming::determinant(d);
  if (!(area > 0.5f && area < 2.0f && d.contrast > 0.5f && d.contrast < 2.0f)) return false;
  // Of both singular values: the sum of squares is `squares`, the product `area`.
  const float squares = d.xx * d.xx + d.xy * d.xy + d.yx * d.yx + d.yy * d.yy;
  constexpr float kLongest = 2.0f;  // a ratio r gives squares = area (r + 1 / r)
  return squares < area * (kLongest + 1.0f / kLongest);
}

bool deform_ref(const KeyPatch& key, const Deformation& d, float damping, DeformedPatch& out) {
  return deforming::deform<Reference>(key, d, damping, out);
}

bool deform_step_ref(const ImageView& im, const DeformedPatch& patch, float& x, float& y,
                     Deformation& d) {
  return deforming::step<Reference>(im, patch, x, y, d);
}

}  // namespace pirvs
