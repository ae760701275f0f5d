// Robust cost of reprojection errors (M-estimator): quadratic near zero, constant far off, so that
// outliers, wrong matches and points that slide along an edge, have no influence.
// In      squared residuals in sigmas (2 degrees of freedom): all of them once before the first
//         step. Where most are large, the states are far off and inliers have large residuals, too:
//         the cost's scale then grows with the median residual.
// Out     cost c^2 s / (c^2 + s) and weight, its derivative by s.
// Errors  none. Cost: 256 bytes.
// Source  Geman, McClure, 1987; Barron, CVPR 2019, for its place among the others.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace pirvs {

class RobustCost {
 public:
  void begin(double sigma) {
    sigma_ = sigma;
    c2_ = sigma * sigma;
    std::fill(counts_, counts_ + kBins, 0u);
  }
  void measure(double squares) {
    const double bin = std::sqrt(squares) * kBinsPerSigma;
    ++counts_[bin < kBins - 1 ? static_cast<int>(bin) : kBins - 1];
  }
  void settle() {
    uint32_t total = 0;
    for (const uint32_t count : counts_) total += count;
    int middle = 0;
    for (uint32_t below = counts_[0]; 2 * below < total; below += counts_[++middle]) {
    }
    const double median = (middle + 1) / kBinsPerSigma;
    const double scale = std::max(1.0, median / kMedianExpected);
    c2_ = sigma_ * sigma_ * scale * scale;
  }

  double cost(double squares) const { return c2_ * squares / (c2_ + squares); }
  double weight(double squares) const {
    const double share = c2_ / (c2_ + squares);
    return share * share;
  }

 private:
  static constexpr int kBins = 64;
  static constexpr double kBinsPerSigma = 4.0;
  static constexpr double kMedianExpected = 1.2;  // sigmas, of two white components

  double sigma_ = 1, c2_ = 1;
  uint32_t counts_[kBins] = {};
};

}  // namespace pirvs
