#include "tools/calib/allan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace pirvs::tools {

std::vector<AllanPoint> allan_deviation(const std::vector<double>& values, double rate_hz) {
  constexpr double kStep = 1.25;      // from one averaging time to the next
  constexpr size_t kAveragesMin = 9;  // of the longest averaging time
  const size_t n = values.size();
  // The sum since the start, of values less their mean so that it keeps its digits.
  double mean = 0;
  for (const double value : values) mean += value / double(n);
  std::vector<double> sum(n + 1, 0);
  for (size_t i = 0; i < n; ++i) sum[i + 1] = sum[i] + (values[i] - mean);
  std::vector<AllanPoint> out;
  size_t last = 0;
  for (double wish = 1; size_t(wish) * kAveragesMin <= n; wish *= kStep) {
    const size_t m = size_t(wish);
    if (m == last) continue;
    last = m;
    double squares = 0;
    const size_t count = n - 2 * m + 1;
    for (size_t i = 0; i < count; ++i) {
      const double d = sum[i + 2 * m] - 2 * sum[i + m] + sum[i];
      squares += d * d;
    }
    const double tau_s = double(m) / rate_hz;
    const double variance = squares / (2 * double(m) * double(m) * double(count));
    out.push_back({tau_s, std::sqrt(variance), double(n) / double(m)});
  }
  return out;
}

double modelled_deviation(const FittedNoise& noise, double tau_s) {
  return std::sqrt(noise.density * noise.density / tau_s + noise.walk * noise.walk * tau_s / 3);
}

// Gauss-Newton on the logarithms of both variances; a point weighs as many independent averages as
// it stands on.
FittedNoise fit_noise(const std::vector<AllanPoint>& points) {
  FittedNoise out;
  if (points.size() < 10) return out;
  const AllanPoint& first = points.front();
  const AllanPoint& last = points.back();
  double n2 = std::log(first.deviation * first.deviation * first.tau_s);
  double k2 = std::log(3 * last.deviation * last.deviation / last.tau_s);
  for (int i = 0; i < 50; ++i) {
    double a = 1e-9, b = 0, c = 1e-9, g = 0, h = 0;
    for (const AllanPoint& p : points) {
      const double white = std::exp(n2) / p.tau_s, walk = std::exp(k2) * p.tau_s / 3;
      const double r = std::log(p.deviation * p.deviation / (white + walk));
      const double by_n = white / (white + walk), by_k = walk / (white + walk);
      a += p.samples * by_n * by_n;
      b += p.samples * by_n * by_k;
      c += p.samples * by_k * by_k;
      g += p.samples * by_n * r;
      h += p.samples * by_k * r;
    }
    const double det = a * c - b * b;
    if (!(det > 0)) break;
    const auto bounded = [](double step) { return std::clamp(step, -1.0, 1.0); };
    n2 += bounded((c * g - b * h) / det);
    k2 += bounded((a * h - b * g) / det);
  }
  out.density = std::exp(n2 / 2);
  out.walk = std::exp(k2 / 2);
  out.floor = std::min_element(points.begin(), points.end(), [](const auto& p, const auto& q) {
                return p.deviation < q.deviation;
              })->deviation;
  return out;
}

}  // namespace pirvs::tools
