#include "core/math/dense_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <limits>
#include <random>
#include <vector>

#include "core/math/types.h"

namespace pirvs {
namespace {

using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Column = Eigen::VectorXd;

struct System {
  System(uint32_t seed, int n) : A(n, n), b(n) {
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    Dense J(n + 5, n);
    for (int i = 0; i < J.size(); ++i) J.data()[i] = normal(engine);
    for (int i = 0; i < n; ++i) b[i] = normal(engine);
    A = J.transpose() * J + 0.1 * Dense::Identity(n, n);
  }
  // The upper triangle with a stride of its own; the lower one and the rest must not be read.
  std::vector<double> upper(size_t stride) const {
    const size_t n = static_cast<size_t>(A.rows());
    std::vector<double> out(n * stride, std::numeric_limits<double>::quiet_NaN());
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = i; j < n; ++j) {
        out[i * stride + j] = A(static_cast<int>(i), static_cast<int>(j));
      }
    }
    return out;
  }
  Dense A;
  Column b;
};

TEST(dense_solver, agrees_with_ldlt) {
  for (const int n : {1, 2, 3, 7, 15, 45, 150, 180}) {
    const System system(static_cast<uint32_t>(n), n);
    const size_t stride = static_cast<size_t>(n) + 3;
    std::vector<double> A = system.upper(stride);
    Column x = system.b;
    ASSERT_TRUE(solve_spd(A.data(), stride, x.data(), static_cast<size_t>(n), nullptr, 0));
    const Column expected = system.A.ldlt().solve(system.b);
    EXPECT_LT((x - expected).norm(), 1e-9 * expected.norm()) << n;
  }
}

TEST(dense_solver, solves_again_from_its_factors) {
  for (const int n : {1, 2, 7, 45, 180}) {
    const System system(static_cast<uint32_t>(n), n);
    const size_t stride = static_cast<size_t>(n) + 3;
    std::vector<double> A = system.upper(stride);
    Column first = system.b;
    ASSERT_TRUE(solve_spd(A.data(), stride, first.data(), static_cast<size_t>(n), nullptr, 0));
    Column b = Column::Zero(n);  // zeros ahead are skipped
    for (int i = n / 3; i < n; ++i) b[i] = system.b[n - 1 - i] + 2;
    Column x = b;
    solve_factored(A.data(), stride, x.data(), static_cast<size_t>(n));
    const Column expected = system.A.ldlt().solve(b);
    EXPECT_LT((x - expected).norm(), 1e-9 * expected.norm()) << n;
  }
}

TEST(dense_solver, skips_zeros_without_losing_any) {
  System system(5, 40);
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) {
      if (std::abs(i - j) > 4) system.A(i, j) = 0;
    }
    system.A(i, i) += 100;
  }
  std::vector<double> A = system.upper(40);
  Column x = system.b;
  ASSERT_TRUE(solve_spd(A.data(), 40, x.data(), 40, nullptr, 0));
  EXPECT_LT((system.A * x - system.b).norm(), 1e-12);
}

TEST(dense_solver, marginal_is_the_schur_complement) {
  for (const int n : {15, 30, 75}) {
    const System system(static_cast<uint32_t>(100 + n), n);
    std::vector<double> A = system.upper(static_cast<size_t>(n));
    Column x = system.b;
    Dense marginal(15, 15);
    ASSERT_TRUE(solve_spd(A.data(), static_cast<size_t>(n), x.data(), static_cast<size_t>(n),
                          marginal.data(), 15));
    // The information that is left is the inverse of the covariance's last block.
    const Dense cov = system.A.inverse();
    const Dense expected = Dense(cov.bottomRightCorner(15, 15)).inverse();
    EXPECT_LT((marginal - expected).norm(), 1e-8 * expected.norm()) << n;
    EXPECT_EQ(marginal, Dense(marginal.transpose()));
  }
}

TEST(dense_solver, refuses_what_is_not_positive_definite) {
  System system(9, 20);
  const Dense good = system.A;
  const auto solves = [&] {
    std::vector<double> A = system.upper(20);
    Column x = system.b;
    return solve_spd(A.data(), 20, x.data(), 20, nullptr, 0);
  };
  EXPECT_TRUE(solves());
  system.A(19, 19) = -system.A(19, 19);
  EXPECT_FALSE(solves()) << "a negative last pivot";
  system.A = good;
  system.A(0, 0) = 0;
  EXPECT_FALSE(solves()) << "a zero first pivot";
  system.A = good;
  system.A(3, 7) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solves()) << "not a number";
  system.A = -good;
  EXPECT_FALSE(solves()) << "negative definite";
}

TEST(dense_solver, same_input_same_bits) {
  const System system(11, 60);
  std::vector<double> A = system.upper(60), B = system.upper(60);
  Column x = system.b, y = system.b;
  ASSERT_TRUE(solve_spd(A.data(), 60, x.data(), 60, nullptr, 0));
  ASSERT_TRUE(solve_spd(B.data(), 60, y.data(), 60, nullptr, 0));
  EXPECT_EQ(x, y);
}

}  // namespace
}  // namespace pirvs
