// Names of the fixed-size matrices, and the one way to include Eigen.
// In, Out Column-major doubles; MatRC has R rows and C columns, MatN is square.
// Frames  A name says its own: R_WB, p_WB (STYLE principle 5).
// Errors  none. Not initialized unless stated.
// Cost    Plain arrays: no heap, no hidden vector code, so the same bits on every machine.
// Source  Eigen 3.4. Bit parity needs EIGEN_DONT_VECTORIZE and -ffp-contract=off, everywhere alike:
//         the first also sets alignment, thus the layout of every struct with a matrix in it.
#pragma once

#ifndef EIGEN_DONT_VECTORIZE
#error "compile with -DEIGEN_DONT_VECTORIZE: layout and results depend on it"
#endif

#include <Eigen/Core>

namespace pirvs {

using Vec2 = Eigen::Matrix<double, 2, 1>;
using Vec3 = Eigen::Matrix<double, 3, 1>;
using Vec4 = Eigen::Matrix<double, 4, 1>;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Vec9 = Eigen::Matrix<double, 9, 1>;
using Vec15 = Eigen::Matrix<double, 15, 1>;
using Mat2 = Eigen::Matrix<double, 2, 2>;
using Mat3 = Eigen::Matrix<double, 3, 3>;
using Mat4 = Eigen::Matrix<double, 4, 4>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Mat9 = Eigen::Matrix<double, 9, 9>;
using Mat15 = Eigen::Matrix<double, 15, 15>;
using Mat23 = Eigen::Matrix<double, 2, 3>;
using Mat26 = Eigen::Matrix<double, 2, 6>;
using Mat32 = Eigen::Matrix<double, 3, 2>;
using Mat36 = Eigen::Matrix<double, 3, 6>;
using Mat63 = Eigen::Matrix<double, 6, 3>;

}  // namespace pirvs
