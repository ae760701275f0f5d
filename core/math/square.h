// x to the power of two: of a sigma, its variance.
// Errors  none.
#pragma once

namespace pirvs {

constexpr double square(double x) { return x * x; }

}  // namespace pirvs
