#include <cstring>

#include "core/kernels/corner/corner.h"
#include "core/kernels/corner/corner_best.h"
#include "core/kernels/neon.h"

namespace pirvs {
namespace {

constexpr int kWindow = 5;
constexpr int kColumns = (kCornerSizeMax + kWindow - 1 + 7) / 8 * 8;  // of gradients, in eights

// Image rows pass through from top to bottom. Sums over five rows of gradients are kept per column:
// a new row enters and the one five above leaves. Columns past the rectangle stay readable.
struct Rows {
  int16_t difference[3][kColumns];  // [-1 0 1] of the last three image rows
  int16_t smooth[3][kColumns];      // [1 2 1]
  int16_t gx[kWindow][kColumns];    // of the last five rows of gradients
  int16_t gy[kWindow][kColumns];
  int32_t xx[kColumns], xy[kColumns], yy[kColumns];
};

// Eight columns. Reads p[0..9]. |difference| <= 255, smooth <= 1020.
inline void filter_eight(const uint8_t* p, int16_t* difference, int16_t* smooth) {
  const int16x8_t left = vreinterpretq_s16_u16(neon::load_widened(p));
  const int16x8_t middle = vreinterpretq_s16_u16(neon::load_widened(p + 1));
  const int16x8_t right = vreinterpretq_s16_u16(neon::load_widened(p + 2));
  vst1q_s16(difference, vsubq_s16(right, left));
  vst1q_s16(smooth, vaddq_s16(vaddq_s16(left, right), vaddq_s16(middle, middle)));
}

// p: one pixel left of the first gradient. Reads columns + 2 bytes: the last eight columns repeat
// some.
inline void filter_row(const uint8_t* p, int columns, int16_t* difference, int16_t* smooth) {
  for (int x = 0; x < columns - 8; x += 8) filter_eight(p + x, difference + x, smooth + x);
  const int last = columns - 8;
  filter_eight(p + last, difference + last, smooth + last);
}

// |gradient| <= 1020, so five products stay below 2^23, and so does what enters minus what leaves.
inline void add_difference(int32_t* sums, int16x8_t a, int16x8_t b, int16x8_t a_old,
                           int16x8_t b_old) {
  vst1q_s32(sums, vaddq_s32(vld1q_s32(sums), neon::products_difference_low(a, b, a_old, b_old)));
  vst1q_s32(sums + 4,
            vaddq_s32(vld1q_s32(sums + 4), neon::products_difference_high(a, b, a_old, b_old)));
}

// The gradients between image rows y - 2, y - 1 and y replace those of five rows above.
void add_gradients(Rows& rows, int y, int columns) {
  const int top = (y + 1) % 3, centre = (y + 2) % 3, bottom = y % 3, slot = y % kWindow;
  for (int x = 0; x < columns; x += 8) {
    const int16x8_t above = vld1q_s16(rows.difference[top] + x);
    const int16x8_t here = vld1q_s16(rows.difference[centre] + x);
    const int16x8_t below = vld1q_s16(rows.difference[bottom] + x);
    const int16x8_t gx = vaddq_s16(vaddq_s16(above, below), vaddq_s16(here, here));
    const int16x8_t gy =
        vsubq_s16(vld1q_s16(rows.smooth[bottom] + x), vld1q_s16(rows.smooth[top] + x));
    const int16x8_t gx_old = vld1q_s16(rows.gx[slot] + x), gy_old = vld1q_s16(rows.gy[slot] + x);
    vst1q_s16(rows.gx[slot] + x, gx);
    vst1q_s16(rows.gy[slot] + x, gy);
    add_difference(rows.xx + x, gx, gx, gx_old, gx_old);
    add_difference(rows.xy + x, gx, gy, gx_old, gy_old);
    add_difference(rows.yy + x, gy, gy, gy_old, gy_old);
  }
}

inline int32x4_t sum_two(const int32_t* p) { return vaddq_s32(vld1q_s32(p), vld1q_s32(p + 1)); }

// Four sums over five columns, as two pairs and the fifth. pairs: sum_two(p) becomes that of p + 4.
inline int32x4_t sum_five(const int32_t* p, int32x4_t& pairs) {
  const int32x4_t fifth = vld1q_s32(p + 4);
  const int32x4_t next = vaddq_s32(fifth, vld1q_s32(p + 5));
  const int32x4_t four = vaddq_s32(pairs, vextq_s32(pairs, next, 2));
  pairs = next;
  return vaddq_s32(four, fifth);
}

struct Four {
  int32x4_t xx, xy, yy;
};

// The test of Best::offer on four pixels, in the same float operations. A product above a square is
// positive: then xx > 0 says that yy > 0, too.
inline uint32x4_t beats(const Four& sums, float32x4_t eigenvalue) {
  const float32x4_t xx = vsubq_f32(vcvtq_f32_s32(sums.xx), eigenvalue);
  const float32x4_t yy = vsubq_f32(vcvtq_f32_s32(sums.yy), eigenvalue);
  const float32x4_t xy = vcvtq_f32_s32(sums.xy);
  const uint32x4_t positive = vcgtq_f32(xx, vdupq_n_f32(0.0f));
  return vandq_u32(positive, vcgtq_f32(vmulq_f32(xx, yy), vmulq_f32(xy, xy)));
}

void offer_four(const Four& sums, int x, int y, int count, corner_detail::Best& best) {
  int32_t xx[4], xy[4], yy[4];
  vst1q_s32(xx, sums.xx);
  vst1q_s32(xy, sums.xy);
  vst1q_s32(yy, sums.yy);
  for (int i = 0; i < count && i < 4; ++i) best.offer(xx[i], xy[i], yy[i], x + i, y);
}

}  // namespace

bool corner_best_neon(const ImageView& im, int x0, int y0, int w, int h, float response_min,
                      Corner& out) {
  corner_detail::check(im, x0, y0, w, h);
  const int columns = w + kWindow - 1;
  // Too narrow for a vector; nobody looks for corners there, but the contract allows it.
  if (columns < 8) return corner_best_ref(im, x0, y0, w, h, response_min, out);
  corner_detail::Best best(response_min);
  Rows rows;
  std::memset(&rows, 0, sizeof rows);
  for (int y = 0; y < h + kWindow + 1; ++y) {  // image row y0 - 3 + y
    filter_row(im.row(y0 - 3 + y) + x0 - 3, columns, rows.difference[y % 3], rows.smooth[y % 3]);
    if (y < 2) continue;
    add_gradients(rows, y, columns);
    if (y < kWindow + 1) continue;
    Four pairs = {sum_two(rows.xx), sum_two(rows.xy), sum_two(rows.yy)};
    for (int x = 0; x < w; x += 4) {
      const Four sums = {sum_five(rows.xx + x, pairs.xx), sum_five(rows.xy + x, pairs.xy),
                         sum_five(rows.yy + x, pairs.yy)};
      if (neon::any(beats(sums, vdupq_n_f32(best.eigenvalue))))
        offer_four(sums, x0 + x, y0 + y - kWindow - 1, w - x, best);
    }
  }
  return best.finish(out);
}

}  // namespace pirvs
