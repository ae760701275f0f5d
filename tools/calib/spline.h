// What    The body's motion as two uniform B-splines of order 6: rotation (cumulative, on SO3) and
//         position. Four times continuously differentiable.
// In      Knots: R and p each dt apart. A time: the segment it lies in and u, its place therein.
// Out     Pose, body rate, velocity and acceleration, and their derivatives by the knots: of a
//         rotation knot as R Exp(theta).
// Frames  T: the board, the world here. B: the body. R_TB, p_TB; w_B in B; v_T, a_T in T.
// Units   s, m, rad.
// Errors  none: u a little outside [0, 1) continues the segment's polynomials.
// Cost    ~1.5 us a state with derivatives.
// Source  Sommer, Usenko, Schubert, Demmel, Cremers, CVPR 2020, sections 3 to 5; Qin 2000 for the
//         basis.
#pragma once

#include <cstddef>

#include "core/math/se3.h"

namespace pirvs::tools {

inline constexpr int kSplineOrder = 6;

struct SplineTime {
  int first = 0;  // of kSplineOrder knots
  double u = 0;
};

// Weights of the six knots, and cumulative weights of the increments between them, with their first
// and second derivatives by time.
struct SplineBasis {
  double b[3][kSplineOrder];
  double c[3][kSplineOrder];  // c[.][0] is constant: 1, 0, 0
};
SplineBasis spline_basis(double u, double dt_s);

struct RotationState {
  Mat3 R_TB;
  Vec3 w_B;
  Mat3 dR[kSplineOrder];  // d theta of R_TB / d theta of a knot
  Mat3 dw[kSplineOrder];  // d w_B / d theta of a knot
};
// q: six quaternions x y z w. Without rates: w_B and dw are left as they are.
RotationState rotation_at(const double* const* q, const SplineBasis& basis, bool rates);

}  // namespace pirvs::tools
