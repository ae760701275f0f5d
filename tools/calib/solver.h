// What    What all adjustments share over Ceres: rotations as unknowns, and the covariance of some
//         unknowns with all others marginalized.
// In      Rotations lie in memory as quaternions x y z w. A cost function writes the derivative by
//         theta of R Exp(theta) into the first three columns of the block and zero into the fourth.
// Out     marginal_covariance: rows and columns in the order of the blocks, three for a rotation,
//         for residuals of sigma 1. influence, where it is asked for: -d block / d residual, a row
//         for each residual in the order they were added, loss applied.
// Errors  marginal_covariance: false if some unknown is not observed at all.
// Cost    marginal_covariance: one sparse Cholesky factor.
// Source  Ceres 2.1; the normal equations are scaled to a unit diagonal.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Core>
#include <vector>

#include "core/math/types.h"

namespace pirvs::tools {

class RotationManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* q, const double* theta, double* out) const override;
  bool PlusJacobian(const double* q, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* theta) const override;
  bool MinusJacobian(const double* q, double* jacobian) const override;
};

struct Rotation {
  explicit Rotation(const Mat3& R = Mat3::Identity());
  Mat3 matrix() const;
  double q[4];
};
Mat3 matrix_of(const double* q);

// (x - mean) / sigma, one block.
class PriorCost final : public ceres::CostFunction {
 public:
  PriorCost(const Eigen::VectorXd& mean, const Eigen::VectorXd& sigma);
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override;

 private:
  Eigen::VectorXd mean_, sigma_;
};

bool marginal_covariance(ceres::Problem& problem, const std::vector<double*>& blocks,
                         Eigen::MatrixXd& out, Eigen::MatrixXd* influence = nullptr);

ceres::Solver::Options solver_options(int steps_max);

}  // namespace pirvs::tools
