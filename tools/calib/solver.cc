#include "tools/calib/solver.h"

#include <Eigen/SparseCholesky>
#include <map>

#include "core/math/so3.h"

namespace pirvs::tools {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

// Columns of each block in the Jacobian, as Ceres orders them.
std::map<const double*, std::pair<int, int>> columns_of(const ceres::Problem& problem,
                                                        std::vector<double*>& blocks) {
  std::map<const double*, std::pair<int, int>> out;
  int at = 0;
  std::vector<double*> all;
  problem.GetParameterBlocks(&all);
  for (double* block : all) {
    if (problem.IsParameterBlockConstant(block)) continue;
    const int size = problem.ParameterBlockTangentSize(block);
    out[block] = {at, size};
    blocks.push_back(block);
    at += size;
  }
  return out;
}

Sparse sparse(const ceres::CRSMatrix& J) {
  return Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>>(
      J.num_rows, J.num_cols, J.rows.back(), J.rows.data(), J.cols.data(), J.values.data());
}

}  // namespace

Mat3 matrix_of(const double* q) { return rotation_from_quat_xyzw(Eigen::Map<const Vec4>(q)); }

Rotation::Rotation(const Mat3& R) { Eigen::Map<Vec4>(this->q) = quat_xyzw(R); }

Mat3 Rotation::matrix() const { return matrix_of(q); }

bool RotationManifold::Plus(const double* q, const double* theta, double* out) const {
  // A step of many turns is nonsense; the cost that it leads to has Ceres take a shorter one.
  constexpr double kStep_rad_max = 10;
  Vec3 turn = Eigen::Map<const Vec3>(theta);
  if (!turn.allFinite()) return false;
  if (turn.norm() > kStep_rad_max) turn *= kStep_rad_max / turn.norm();
  const Mat3 R = matrix_of(q) * so3_exp(turn);
  Eigen::Map<Vec4>(out).noalias() = quat_xyzw(R);
  return true;
}

bool RotationManifold::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 4, 3, Eigen::RowMajor>>(jacobian).setIdentity();
  return true;
}

bool RotationManifold::Minus(const double* y, const double* x, double* theta) const {
  Eigen::Map<Vec3>(theta).noalias() = so3_log(matrix_of(x).transpose() * matrix_of(y));
  return true;
}

bool RotationManifold::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(jacobian).setIdentity();
  return true;
}

bool marginal_covariance(ceres::Problem& problem, const std::vector<double*>& blocks,
                         Eigen::MatrixXd& out, Eigen::MatrixXd* influence) {
  ceres::Problem::EvaluateOptions how;
  const auto columns = columns_of(problem, how.parameter_blocks);
  ceres::CRSMatrix rows;
  if (!problem.Evaluate(how, nullptr, nullptr, nullptr, &rows)) return false;
  const Sparse J = sparse(rows);
  Sparse A = J.transpose() * J;
  const Eigen::VectorXd diagonal = A.diagonal();
  if (!(diagonal.minCoeff() > 0)) return false;
  const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  A = Sparse(scale.asDiagonal() * A * scale.asDiagonal());
  const Eigen::SimplicialLDLT<Sparse> factor(A);
  if (factor.info() != Eigen::Success) return false;
  std::vector<int> wanted;
  for (const double* block : blocks) {
    const auto [at, size] = columns.at(block);
    for (int i = 0; i < size; ++i) wanted.push_back(at + i);
  }
  const auto n = Eigen::Index(wanted.size());
  out.resize(n, n);
  if (influence != nullptr) influence->resize(J.rows(), n);
  for (Eigen::Index j = 0; j < n; ++j) {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(A.rows());
    b[wanted[size_t(j)]] = scale[wanted[size_t(j)]];
    const Eigen::VectorXd x = factor.solve(b).cwiseProduct(scale);
    for (Eigen::Index i = 0; i < n; ++i) out(i, j) = x[wanted[size_t(i)]];
    if (influence != nullptr) influence->col(j) = J * x;
  }
  return out.allFinite() && out.diagonal().minCoeff() > 0;
}

PriorCost::PriorCost(const Eigen::VectorXd& mean, const Eigen::VectorXd& sigma)
    : mean_(mean), sigma_(sigma) {
  set_num_residuals(int(mean.size()));
  mutable_parameter_block_sizes()->push_back(int(mean.size()));
}

bool PriorCost::Evaluate(double const* const* x, double* residuals, double** jacobians) const {
  const Eigen::Index n = mean_.size();
  const Eigen::Map<const Eigen::VectorXd> value(x[0], n);
  Eigen::Map<Eigen::VectorXd>(residuals, n) = (value - mean_).cwiseQuotient(sigma_);
  if (jacobians == nullptr || jacobians[0] == nullptr) return true;
  Eigen::Map<Eigen::MatrixXd>(jacobians[0], n, n) = sigma_.cwiseInverse().asDiagonal();
  return true;
}

ceres::Solver::Options solver_options(int steps_max) {
  ceres::Solver::Options out;
  out.max_num_iterations = steps_max;
  out.num_threads = 2;
  out.logging_type = ceres::SILENT;
  out.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  out.function_tolerance = 1e-8;
  return out;
}

}  // namespace pirvs::tools
