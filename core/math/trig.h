// Elementary functions with the same bits on every machine (libm's differ between C libraries).
// In      Radians; |x| < 1e6 for sine, cosine and sincos (a bug beyond: asserts); any double else.
// Out     Error bounds against the exact value, tested against libm: see each line.
// Errors  NaN gives NaN. logarithm(0) = -inf, of a negative number NaN. arccos clamps to [-1, 1].
//         exponential overflows to inf and gives 0 where the result would be subnormal.
// Cost    About 9 ns, x86-64 at 2.1 GHz; only + - * / sqrt, floor and integer operations.
// Source  Argument reductions and polynomials of fdlibm 5.3 (Sun Microsystems, 1993).
#pragma once

namespace pirvs {

inline constexpr double kPi = 3.14159265358979323846;

void sincos(double x, double& s, double& c);  // < 1 ulp
double sine(double x);
double cosine(double x);
double arctan(double x);             // < 1 ulp
double arctan2(double y, double x);  // < 2 ulp; (-pi, pi], and arctan2(0, 0) = 0
double arccos(double x);             // < 2 ulp
double exponential(double x);        // < 1 ulp
double logarithm(double x);          // < 1 ulp

}  // namespace pirvs
