#include "core/kernels/describe/describe.h"
#include "core/kernels/describe/describe_place.h"
#include "core/kernels/neon.h"

namespace pirvs {
namespace {

using namespace describe_detail;

constexpr int kStride = 32;  // of the smoothed patch
constexpr int kEights = 5;   // column blocks of the 36 columns that are read
constexpr int kFirst[kEights] = {0, 8, 16, 24, 28};  // the last one repeats four columns
static_assert(kSide_px < kStride && kStride + 2 * kSmooth_px == kFirst[kEights - 1] + 8);
static_assert(kStride - kRadius_px + kSmooth_px < kDescribeMargin_px, "right of what is read");

// Sums over 5 x 5 pixels: at most 25 * 255 = 6375. Sums of five rows are kept per column; a new row
// enters and the one five rows above leaves. corner: upper left of the 36 x 35 pixels read.
void smooth(const uint8_t* corner, int stride, uint16_t* out) {
  uint16x8_t sums[kEights];
  for (int k = 0; k < kEights; ++k) {
    sums[k] = vdupq_n_u16(0);
    for (int j = 0; j < 2 * kSmooth_px; ++j)
      sums[k] = vaddq_u16(
          sums[k], neon::load_widened(corner + static_cast<int64_t>(j) * stride + kFirst[k]));
  }
  uint16_t columns[kStride + 2 * kSmooth_px];
  for (int y = 0; y < kSide_px; ++y, corner += stride, out += kStride) {
    const uint8_t* enters = corner + static_cast<int64_t>(2 * kSmooth_px) * stride;
    for (int k = 0; k < kEights; ++k) {
      sums[k] = vaddq_u16(sums[k], neon::load_widened(enters + kFirst[k]));
      vst1q_u16(columns + kFirst[k], sums[k]);
      sums[k] = vsubq_u16(sums[k], neon::load_widened(corner + kFirst[k]));
    }
    for (int x = 0; x < kStride; x += 8) {
      const uint16_t* c = columns + x;
      const uint16x8_t outer = vaddq_u16(vld1q_u16(c), vld1q_u16(c + 4));
      const uint16x8_t inner = vaddq_u16(vld1q_u16(c + 1), vld1q_u16(c + 3));
      vst1q_u16(out + x, vaddq_u16(vaddq_u16(outer, inner), vld1q_u16(c + 2)));
    }
  }
}

// Where each turned pattern point lies in the smoothed patch. A turned coordinate is at most
// 15 * 1024 and its two products 2 * 15 * 1024 = 30720, which with rounding fits int16.
void turn(const int16_t* px, const int16_t* py, const Place& at, uint16_t* index) {
  const int16x8_t cos_a = vdupq_n_s16(at.cos_a), sin_a = vdupq_n_s16(at.sin_a);
  const int16x8_t half = vdupq_n_s16(kUnit / 2);
  const int16x8_t centre = vdupq_n_s16(kRadius_px * kStride + kRadius_px);
  for (int i = 0; i < 256; i += 8) {
    const int16x8_t x = vld1q_s16(px + i), y = vld1q_s16(py + i);
    const int16x8_t turned_x = vsubq_s16(vmulq_s16(x, cos_a), vmulq_s16(y, sin_a));
    const int16x8_t turned_y = vaddq_s16(vmulq_s16(x, sin_a), vmulq_s16(y, cos_a));
    const int16x8_t column = vshrq_n_s16(vaddq_s16(turned_x, half), 10);
    const int16x8_t row = vshrq_n_s16(vaddq_s16(turned_y, half), 10);
    const int16x8_t at_patch = vaddq_s16(vaddq_s16(vshlq_n_s16(row, 5), column), centre);
    vst1q_u16(index + i, vreinterpretq_u16_s16(at_patch));
  }
}

}  // namespace

void describe_neon(const ImageView& im, float x, float y, float cos_a, float sin_a,
                   Descriptor& out) {
  const Place at = place(im, x, y, cos_a, sin_a);
  constexpr int kReach_px = kRadius_px + kSmooth_px;
  alignas(16) uint16_t patch[kSide_px * kStride];
  alignas(16) uint16_t index_a[256], index_b[256];
  smooth(im.row(at.y - kReach_px) + at.x - kReach_px, im.stride, patch);
  turn(kAx, kAy, at, index_a);
  turn(kBx, kBy, at, index_b);
  // No gather exists, so lookups are scalar; the comparison's carry goes straight into the word.
  for (int word = 0; word < 4; ++word) {
    uint64_t bits = 0;
    for (int i = word * 64; i < word * 64 + 64; ++i)
      bits = bits + bits + (patch[index_a[i]] < patch[index_b[i]]);
    out.w[word] = bits;
  }
}

}  // namespace pirvs
