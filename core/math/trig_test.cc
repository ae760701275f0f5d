#include "core/math/trig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

namespace pirvs {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kSamples = 200'000;

// Distance from the value computed in long double, in units of the last place of that value.
double ulps(double got, long double want) {
  const double near = static_cast<double>(want);
  const double ulp = std::nextafter(std::fabs(near), kInfinity) - std::fabs(near);
  return static_cast<double>(std::fabs(static_cast<long double>(got) - want) / ulp);
}

double uniform(std::mt19937_64& rng, double low, double high) {
  return low + (high - low) * (static_cast<double>(rng() >> 11) * 0x1p-53);
}

TEST(Trig, SineAndCosineMatchLibm) {
  std::mt19937_64 rng(1);
  double worst = 0.0, worst_far = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double range = i % 4 == 0 ? 1e-3 : i % 4 == 1 ? 1.0 : i % 4 == 2 ? 7.0 : 999'000.0;
    const double x = uniform(rng, -range, range);
    double s, c;
    sincos(x, s, c);
    double& bound = range > 10.0 ? worst_far : worst;
    bound = std::fmax(bound, std::fmax(ulps(s, sinl(x)), ulps(c, cosl(x))));
    ASSERT_EQ(s, sine(x));
    ASSERT_EQ(c, cosine(x));
  }
  EXPECT_LT(worst, 1.0);
  EXPECT_LT(worst_far, 1.0);
}

TEST(Trig, SineAndCosineNearMultiplesOfHalfPi) {
  double worst = 0.0;
  for (int n = -2000; n <= 2000; ++n) {
    const double x = n * (kPi / 2);
    double s, c;
    sincos(x, s, c);
    // The smaller one is of the size of the rounding of x, 1e-13 and below.
    worst = std::fmax(worst, static_cast<double>(fabsl(s - sinl(x)) + fabsl(c - cosl(x))));
  }
  EXPECT_LT(worst, 2.3e-16);
}

TEST(Trig, InverseFunctionsMatchLibm) {
  std::mt19937_64 rng(2);
  double worst_arctan = 0.0, worst_arctan2 = 0.0, worst_arccos = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = uniform(rng, -4.0, 4.0) * (i % 3 == 0 ? 1e-3 : i % 3 == 1 ? 1.0 : 1e3);
    const double y = uniform(rng, -4.0, 4.0);
    const double a = uniform(rng, -1.0, 1.0);
    worst_arctan = std::fmax(worst_arctan, ulps(arctan(x), atanl(x)));
    worst_arctan2 = std::fmax(worst_arctan2, ulps(arctan2(y, x), atan2l(y, x)));
    worst_arccos = std::fmax(worst_arccos, ulps(arccos(a), acosl(a)));
  }
  EXPECT_LT(worst_arctan, 1.0);
  EXPECT_LT(worst_arctan2, 2.0);
  EXPECT_LT(worst_arccos, 2.0);
}

TEST(Trig, ExponentialAndLogarithmMatchLibm) {
  std::mt19937_64 rng(3);
  double worst_exp = 0.0, worst_log = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = uniform(rng, -1.0, 1.0) * (i % 2 == 0 ? 2.0 : 700.0);
    worst_exp = std::fmax(worst_exp, ulps(exponential(x), expl(x)));
    const double y = i % 2 == 0 ? uniform(rng, 0.5, 2.0) : std::exp(x);
    worst_log = std::fmax(worst_log, ulps(logarithm(y), logl(y)));
  }
  EXPECT_LT(worst_exp, 1.0);
  EXPECT_LT(worst_log, 1.0);
}

TEST(Trig, SpecialValues) {
  EXPECT_EQ(sine(0.0), 0.0);
  EXPECT_EQ(cosine(0.0), 1.0);
  EXPECT_EQ(arctan(kInfinity), kPi / 2);
  EXPECT_EQ(arctan2(0.0, 0.0), 0.0);
  EXPECT_EQ(arctan2(0.0, -1.0), kPi);
  EXPECT_EQ(arctan2(-1.0, 0.0), -kPi / 2);
  EXPECT_EQ(arccos(1.0 + 1e-15), 0.0);
  EXPECT_EQ(arccos(-2.0), kPi);
  EXPECT_EQ(exponential(0.0), 1.0);
  EXPECT_EQ(exponential(710.0), kInfinity);
  EXPECT_EQ(exponential(-1000.0), 0.0);
  EXPECT_GT(exponential(709.78), 1.79e308);
  EXPECT_EQ(logarithm(1.0), 0.0);
  EXPECT_EQ(logarithm(0.0), -kInfinity);
  EXPECT_TRUE(std::isnan(logarithm(-1.0)));
  EXPECT_NEAR(logarithm(5e-324), -744.4400719213812, 1e-12);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(sine(nan)) && std::isnan(cosine(nan)) && std::isnan(arctan(nan)) &&
              std::isnan(arctan2(nan, 1.0)) && std::isnan(arccos(nan)) &&
              std::isnan(exponential(nan)) && std::isnan(logarithm(nan)));
  EXPECT_DEATH(sine(1e6), "bug");
}

}  // namespace
}  // namespace pirvs
