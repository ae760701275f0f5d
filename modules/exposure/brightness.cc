#include "modules/exposure/brightness.h"

#include <algorithm>

#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr int kWhite = 255;
constexpr int kSaturated = 252;  // sensors and lenses do not all reach 255
constexpr double kBright = 235;  // highlights begin here
constexpr int kShift = 5;        // of the grid from row to row: odd, so that all columns are met

// By the share of pixels that are saturated: the grey they would have if there were more than 255.
double level_of_saturated(double share) {
  const double square = share * share;
  return kWhite * (1.3 + 3.0 * square + 4.0 * square * square);
}

}  // namespace

void add(const ImageView& image, Histogram& histogram) {
  int shift = 0;
  for (int y = kGrid_px / 2; y < image.height; y += kGrid_px) {
    const uint8_t* const row = image.row(y);
    for (int x = shift; x < image.width; x += kGrid_px) {
      ++histogram.count[row[x]];
      ++histogram.total;
    }
    shift = (shift + kShift) % kGrid_px;
  }
}

double mean_of(const Histogram& histogram) {
  double sum = 0;
  for (int grey = 0; grey <= kWhite; ++grey)
    sum += static_cast<double>(grey) * histogram.count[grey];
  return histogram.total > 0 ? sum / histogram.total : 0;
}

double correction(const Histogram& histogram, double mean_grey, double highlights) {
  if (histogram.total == 0) return 1;
  double saturated = 0;
  for (int grey = kSaturated; grey <= kWhite; ++grey) saturated += histogram.count[grey];
  const double level = level_of_saturated(saturated / histogram.total);
  const auto weight = [&](double grey, double factor) {
    const double seen = std::min(grey * factor, double{kWhite});
    const double bright = std::max(0.0, (seen - kBright) / (kWhite - kBright));
    return seen + highlights * kWhite * bright;
  };
  // The weighted mean grows with the factor: bisection of its logarithm.
  const double wanted = mean_grey * histogram.total;
  double low = -logarithm(kStep_max), high = -low;
  constexpr int kHalvings = 11;  // to 0.3 %
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    const double factor = exponential(middle);
    double sum = saturated * weight(level, factor);
    for (int grey = 0; grey < kSaturated; ++grey) {
      if (histogram.count[grey] != 0) sum += histogram.count[grey] * weight(grey, factor);
    }
    (sum < wanted ? low : high) = middle;
  }
  return exponential((low + high) / 2);
}

}  // namespace pirvs
