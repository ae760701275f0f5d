#include "core/math/trig.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/base/assert.h"

namespace pirvs {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLn2High = 6.93147180369123816490e-01;  // 33 bits, so that k * kLn2High is exact
constexpr double kLn2Low = 1.90821492927058770002e-10;

// 2^k for k in [-1022, 1023].
double power_of_two(int k) {
  const uint64_t bits = static_cast<uint64_t>(k + 1023) << 52;
  double value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

// sin(x + tail) for |x| < pi / 4 and tail below an ulp of x.
double sine_kernel(double x, double tail) {
  const double z = x * x;
  const double v = z * x;
  const double r = 8.33333333332248946124e-03 +
                   z * (-1.98412698298579493134e-04 +
                        z * (2.75573137070700676789e-06 +
                             z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  return x - ((z * (0.5 * tail - v * r) - tail) - v * -1.66666666666666324348e-01);
}

// cos(x + tail), likewise.
double cosine_kernel(double x, double tail) {
  const double z = x * x;
  const double r =
      z * (4.16666666666666019037e-02 +
           z * (-1.38888888888741095749e-03 +
                z * (2.48015872894767294178e-05 +
                     z * (-2.75573143513906633035e-07 +
                          z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
  const double half = 0.5 * z;
  const double w = 1.0 - half;
  return w + (((1.0 - w) - half) + (z * r - x * tail));
}

// x = quadrant * pi / 2 + (r + tail), |r| <= pi / 4. Two 33-bit parts of pi / 2 times an integer
// below 2^20 are exact; what the subtractions lose goes into the tail.
int reduce(double x, double& r, double& tail) {
  PIRVS_ASSERT(!(std::fabs(x) >= 1e6));
  constexpr double kPio2Part1 = 1.57079632673412561417e+00;
  constexpr double kPio2Part2 = 6.07710050630396597660e-11;
  constexpr double kPio2Part3 = 2.02226624879595063154e-21;
  const double n = std::floor(x * (2.0 / kPi) + 0.5);
  const double a = x - n * kPio2Part1;  // exact: the two agree in their leading bits
  const double w = n * kPio2Part2;
  const double b = a - w;
  const double lost = ((a - b) - w) - n * kPio2Part3;
  r = b + lost;
  tail = (b - r) + lost;
  return static_cast<int>(n) & 3;
}

}  // namespace

void sincos(double x, double& s, double& c) {
  if (x != x) {
    s = c = x;
    return;
  }
  double r, tail;
  const int quadrant = reduce(x, r, tail);
  const double sr = sine_kernel(r, tail);
  const double cr = cosine_kernel(r, tail);
  const bool swap = (quadrant & 1) != 0;
  s = swap ? cr : sr;
  c = swap ? sr : cr;
  if ((quadrant & 2) != 0) s = -s;
  if (((quadrant + 1) & 2) != 0) c = -c;
}

double sine(double x) {
  double s, c;
  sincos(x, s, c);
  return s;
}

double cosine(double x) {
  double s, c;
  sincos(x, s, c);
  return c;
}

double arctan(double x) {
  const double a = std::fabs(x);
  if (!(a < 1e17)) return x != x ? x : std::copysign(kPi / 2, x);
  // a = tan(base + rest): rest stays below tan(7/16), where the polynomial is good.
  double high = 0.0, low = 0.0, t = a;
  if (a >= 2.4375) {
    high = 1.57079632679489655800e+00, low = 6.12323399573676603587e-17;
    t = -1.0 / a;
  } else if (a >= 1.1875) {
    high = 9.82793723247329054082e-01, low = 1.39033110312309984516e-17;
    t = (a - 1.5) / (1.0 + 1.5 * a);
  } else if (a >= 0.6875) {
    high = 7.85398163397448278999e-01, low = 3.06161699786838301793e-17;
    t = (a - 1.0) / (a + 1.0);
  } else if (a >= 0.4375) {
    high = 4.63647609000806093515e-01, low = 2.26987774529616870924e-17;
    t = (2.0 * a - 1.0) / (2.0 + a);
  }
  const double z = t * t;
  const double w = z * z;
  const double s1 =
      z * (3.33333333333329318027e-01 +
           w * (1.42857142725034663711e-01 +
                w * (9.09088713343650656196e-02 +
                     w * (6.66107313738753120669e-02 +
                          w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const double s2 =
      w * (-1.99999999998764832476e-01 +
           w * (-1.11111104054623557880e-01 +
                w * (-7.69187620504482999495e-02 +
                     w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  return std::copysign(high - ((t * (s1 + s2) - low) - t), x);
}

double arctan2(double y, double x) {
  if (x != x || y != y) return kNaN;
  if (y == 0.0) return x < 0.0 ? kPi : 0.0;
  if (x == 0.0) return std::copysign(kPi / 2, y);
  constexpr double kPiLow = 1.22464679914735317720e-16;  // pi - kPi
  const double angle = arctan(std::fabs(y / x));
  return std::copysign(x > 0.0 ? angle : kPi - (angle - kPiLow), y);
}

double arccos(double x) {
  if (x >= 1.0) return 0.0;
  if (x <= -1.0) return kPi;
  return arctan2(std::sqrt((1.0 - x) * (1.0 + x)), x);
}

double exponential(double x) {
  if (x != x) return x;
  if (x > 709.782712893383973096) return kInfinity;
  if (x < -708.39641853226408) return 0.0;
  // x = k ln 2 + r, |r| < ln 2 / 2; exp(r) = 1 + r + r c / (2 - c), c an even rational remainder.
  const double k = std::floor(x * 1.44269504088896338700 + 0.5);
  const double high = x - k * kLn2High;
  const double low = k * kLn2Low;
  const double r = high - low;
  const double z = r * r;
  const double c =
      r - z * (1.66666666666666019037e-01 +
               z * (-2.77777777770155933842e-03 +
                    z * (6.61375632143793436117e-05 +
                         z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))));
  const double y = 1.0 - ((low - (r * c) / (2.0 - c)) - high);
  // In two steps, since k reaches 1024 at the upper end.
  const int half = static_cast<int>(k) / 2;
  return y * power_of_two(half) * power_of_two(static_cast<int>(k) - half);
}

double logarithm(double x) {
  if (!(x > 0.0)) return x == 0.0 ? -kInfinity : kNaN;
  if (x == kInfinity) return x;
  int k = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= power_of_two(54);
    k = -54;
  }
  // x = 2^k (1 + f), sqrt(1/2) < 1 + f < sqrt(2).
  uint64_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  constexpr uint64_t kSqrtHalf = 0x3fe6a09e667f3bcdu;
  const int64_t exponent = static_cast<int64_t>(bits - kSqrtHalf) >> 52;
  k += static_cast<int>(exponent);
  bits -= static_cast<uint64_t>(exponent) << 52;
  double m;
  std::memcpy(&m, &bits, sizeof m);
  const double f = m - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  const double w = z * z;
  const double t1 = w * (3.999999999940941908e-01 +
                         w * (2.222219843214978396e-01 + w * 1.531383769920937332e-01));
  const double t2 = z * (6.666666666666735130e-01 +
                         w * (2.857142874366239149e-01 +
                              w * (1.818357216161805012e-01 + w * 1.479819860511658591e-01)));
  const double half = 0.5 * f * f;
  const double dk = static_cast<double>(k);
  return dk * kLn2High - ((half - (s * (half + (t1 + t2)) + dk * kLn2Low)) - f);
}

}  // namespace pirvs
