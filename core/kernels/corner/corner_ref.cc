#include "core/kernels/corner/corner.h"
#include "core/kernels/corner/corner_best.h"

namespace pirvs {
namespace {

int sobel_x(const ImageView& im, int x, int y) {
  const uint8_t *a = im.row(y - 1) + x, *b = im.row(y) + x, *c = im.row(y + 1) + x;
  return a[1] - a[-1] + 2 * (b[1] - b[-1]) + c[1] - c[-1];
}

int sobel_y(const ImageView& im, int x, int y) {
  const uint8_t *a = im.row(y - 1) + x, *c = im.row(y + 1) + x;
  return c[-1] + 2 * c[0] + c[1] - a[-1] - 2 * a[0] - a[1];
}

}  // namespace

bool corner_best_ref(const ImageView& im, int x0, int y0, int w, int h, float response_min,
                     Corner& out) {
  corner_detail::check(im, x0, y0, w, h);
  corner_detail::Best best(response_min);
  for (int y = y0; y < y0 + h; ++y)
    for (int x = x0; x < x0 + w; ++x) {
      int32_t xx = 0, xy = 0, yy = 0;
      for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i) {
          const int gx = sobel_x(im, x + i, y + j), gy = sobel_y(im, x + i, y + j);
          xx += gx * gx;
          xy += gx * gy;
          yy += gy * gy;
        }
      best.offer(xx, xy, yy, x, y);
    }
  return best.finish(out);
}

}  // namespace pirvs
