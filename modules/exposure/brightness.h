// How bright images are: a histogram over a sparse grid, and by what factor their grey should
// change.
// In      8-bit grey images of any size. Every kGrid_px-th pixel of every kGrid_px-th row, shifted
//         from row to row, so that no regular pattern of the scene is met by all of them.
// Out     Histogram; correction(): the factor on grey after which the mean, in which highlights
//         count more than once, is `mean_grey`. Clipping at 255 is predicted. Saturated pixels are
//         taken to be brighter than 255 the more of them there are.
// Units   grey, 0 to 255.
// Errors  None. Without pixels the factor is 1. A factor lies within 1 / kStep_max and kStep_max.
// Cost    752 x 480: see auto_exposure.h.
// Source  Share of saturated pixels as a measure of what lies above them: tuned with a simulated
//         sensor (auto_exposure_test.cc).
#pragma once

#include <cstdint>

#include "core/kernels/image.h"

namespace pirvs {

inline constexpr int kGrid_px = 16;
inline constexpr double kStep_max = 16;

struct Histogram {
  uint32_t count[256] = {};
  uint32_t total = 0;
};

void add(const ImageView& image, Histogram& histogram);
double mean_of(const Histogram& histogram);
double correction(const Histogram& histogram, double mean_grey, double highlights);

}  // namespace pirvs
