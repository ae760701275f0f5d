#include "modules/output/latency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace pirvs {
namespace {

constexpr double kError = 1.0 / 64;  // as the header says

TEST(Latency, SaysThatThereIsNothing) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.summary().count, 0u);
}

TEST(Latency, IsExactForOneValue) {
  for (const TimeNs value : {TimeNs{0}, TimeNs{63}, TimeNs{64}, TimeNs{1'234'567}}) {
    LatencyHistogram histogram;
    histogram.add(value);
    const LatencySummary s = histogram.summary();
    EXPECT_EQ(s.count, 1u);
    for (const double ms : {s.min_ms, s.median_ms, s.p99_ms, s.max_ms}) {
      EXPECT_DOUBLE_EQ(ms, static_cast<double>(value) * 1e-6);
    }
  }
}

// Against sorting, from nanoseconds to a minute.
TEST(Latency, KeepsItsErrorOverTenDecades) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> exponent(0, 0.2 * (1 + seed));
    LatencyHistogram histogram;
    std::vector<double> sorted;
    for (int i = 0; i < 2001; ++i) {
      const auto value = static_cast<TimeNs>(std::pow(10.0, exponent(engine)));
      histogram.add(value);
      sorted.push_back(static_cast<double>(value) * 1e-6);
    }
    std::sort(sorted.begin(), sorted.end());
    const LatencySummary s = histogram.summary();
    EXPECT_EQ(s.count, sorted.size());
    EXPECT_DOUBLE_EQ(s.min_ms, sorted.front());
    EXPECT_DOUBLE_EQ(s.max_ms, sorted.back());
    EXPECT_NEAR(s.median_ms, sorted[1000], kError * sorted[1000]) << "seed " << seed;
    EXPECT_NEAR(s.p99_ms, sorted[1980], kError * sorted[1980]) << "seed " << seed;
  }
}

TEST(Latency, StaysWithinItsRange) {
  LatencyHistogram histogram;
  histogram.add(-5'000'000);
  histogram.add(INT64_MAX);
  const LatencySummary s = histogram.summary();
  EXPECT_EQ(s.min_ms, 0);
  EXPECT_NEAR(s.max_ms, 68'719.5, 0.1);
}

}  // namespace
}  // namespace pirvs
