#include "tools/calib/allan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/sim/random.h"

namespace pirvs::tools {
namespace {

std::vector<double> rest(double density, double walk, double rate_hz, double duration_s,
                         uint64_t seed) {
  Random random(seed, 1);
  std::vector<double> out;
  double bias = 0.01;
  for (size_t i = 0; i < size_t(duration_s * rate_hz); ++i) {
    out.push_back(bias + density * std::sqrt(rate_hz) * random.normal());
    bias += walk / std::sqrt(rate_hz) * random.normal();
  }
  return out;
}

TEST(allan, finds_density_and_walk_of_a_long_rest) {
  constexpr double kDensity = 2e-3, kWalk = 1e-3, kRate_hz = 20;
  double density = 0, walk = 0;
  constexpr int kSeeds = 3;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const FittedNoise noise =
        fit_noise(allan_deviation(rest(kDensity, kWalk, kRate_hz, 3600, seed), kRate_hz));
    density += noise.density / kSeeds;
    walk += noise.walk / kSeeds;
  }
  EXPECT_NEAR(density, kDensity, 0.03 * kDensity);
  EXPECT_NEAR(walk, kWalk, 0.1 * kWalk);
}

TEST(allan, white_noise_falls_with_the_root_of_time) {
  const std::vector<AllanPoint> points = allan_deviation(rest(1, 0, 1, 1e5, 4), 1);
  for (const AllanPoint& point : points) {
    if (point.samples < 1000) continue;
    EXPECT_NEAR(point.deviation * std::sqrt(point.tau_s), 1, 0.1) << point.tau_s;
  }
}

TEST(allan, too_short_a_rest_gives_nothing) {
  EXPECT_EQ(fit_noise(allan_deviation(std::vector<double>(20, 1.0), 1)).density, 0);
}

}  // namespace
}  // namespace pirvs::tools
