#include "core/kernels/describe/describe.h"
#include "core/kernels/describe/describe_place.h"

namespace pirvs {
namespace {

using namespace describe_detail;

// Sum of 5 x 5 pixels around pattern point px, py of the turned patch.
int smoothed(const ImageView& im, const Place& at, int px, int py) {
  const int x = at.x + ((px * at.cos_a - py * at.sin_a + kUnit / 2) >> 10);
  const int y = at.y + ((px * at.sin_a + py * at.cos_a + kUnit / 2) >> 10);
  int sum = 0;
  for (int j = -kSmooth_px; j <= kSmooth_px; ++j)
    for (int i = -kSmooth_px; i <= kSmooth_px; ++i) sum += im.row(y + j)[x + i];
  return sum;
}

}  // namespace

void describe_ref(const ImageView& im, float x, float y, float cos_a, float sin_a,
                  Descriptor& out) {
  const Place at = place(im, x, y, cos_a, sin_a);
  out = {};
  for (int i = 0; i < 256; ++i)
    if (smoothed(im, at, kAx[i], kAy[i]) < smoothed(im, at, kBx[i], kBy[i]))
      out.w[i / 64] |= uint64_t{1} << (63 - i % 64);
}

}  // namespace pirvs
