#include "tools/calib/motion_costs.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/math/so3.h"
#include "modules/testing.h"
#include "tools/calib/solver.h"

namespace pirvs::tools {
namespace {

using Vec = std::vector<double>;

// Compares each block's derivative with numeric ones; blocks of four are rotations.
void expect_derivatives(const ceres::CostFunction& cost, std::vector<Vec> x) {
  const int rows = cost.num_residuals();
  std::vector<Vec> J;
  std::vector<double*> out;
  for (const int size : cost.parameter_block_sizes()) J.emplace_back(size_t(rows * size));
  for (Vec& block : J) out.push_back(block.data());
  const auto residuals = [&](double** jacobians) {
    std::vector<const double*> at;
    for (const Vec& block : x) at.push_back(block.data());
    Vec r(static_cast<size_t>(rows));
    EXPECT_TRUE(cost.Evaluate(at.data(), r.data(), jacobians));
    return r;
  };
  residuals(out.data());
  constexpr double kStep = 1e-6;
  for (size_t b = 0; b < x.size(); ++b) {
    const int size = cost.parameter_block_sizes()[b];
    const Vec before = x[b];
    for (int i = 0; i < (size == 4 ? 3 : size); ++i) {
      const auto moved = [&](double step) {
        if (size == 4) {
          const Vec3 theta = step * Vec3::Unit(i);
          RotationManifold().Plus(before.data(), theta.data(), x[b].data());
        } else {
          x[b][size_t(i)] = before[size_t(i)] + step;
        }
        const Vec r = residuals(nullptr);
        x[b] = before;
        return r;
      };
      const Vec low = moved(-kStep), high = moved(kStep);
      for (int row = 0; row < rows; ++row) {
        const double numeric = (high[size_t(row)] - low[size_t(row)]) / (2 * kStep);
        const double analytic = J[b][size_t(row * size + i)];
        EXPECT_NEAR(analytic, numeric, 2e-4 * (1 + std::abs(numeric)))
            << "block " << b << ", " << i << ", residual " << row;
      }
    }
  }
}

Vec as_vector(const double* values, size_t count) { return Vec(values, values + count); }

// Six rotations and six places of a hand that turns by 2 rad/s.
std::vector<Vec> knots(testing::Random& random) {
  std::vector<Vec> out;
  Mat3 R = so3_exp(random.vec(1.0));
  for (int k = 0; k < kSplineOrder; ++k, R = R * so3_exp(random.vec(0.04))) {
    out.push_back(as_vector(Rotation(R).q, 4));
  }
  for (int k = 0; k < kSplineOrder; ++k) {
    const Vec3 p = Vec3(0.3, 0.2, 1) + random.vec(0.01);
    out.push_back(as_vector(p.data(), 3));
  }
  return out;
}

TEST(motion_costs, imu_derivatives_match_numeric) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    testing::Random random(seed);
    ImuReading reading{random.vec(1), random.vec(5), 0.1, 0.5, spline_basis(0.3, 0.02), 0.3};
    std::vector<Vec> x = knots(random);
    const Vec3 gravity = random.vec(1).normalized();
    x.push_back(as_vector(gravity.data(), 3));
    for (const size_t size : {9, 6, 3, 3, 3, 3}) {
      Vec block;
      for (size_t i = 0; i < size; ++i) block.push_back(random.gauss(1));
      x.push_back(block);
    }
    expect_derivatives(ImuCost(reading), x);
  }
}

TEST(motion_costs, frame_derivatives_match_numeric) {
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    testing::Random random(seed);
    std::vector<Vec> x = knots(random);
    const Mat3 R_BC = so3_exp(random.vec(1));
    const Vec3 p_BC = random.vec(0.1);
    x.push_back(as_vector(Rotation(R_BC).q, 4));
    x.push_back(as_vector(p_BC.data(), 3));
    x.push_back({0.003, 1e-4});
    const LensVector lens = lens_of(testing::lens(CameraModel::kPinholeRadtan));
    x.push_back(as_vector(lens.data(), kLensSize));
    FrameFactor factor;
    factor.T_CT = {so3_exp(random.vec(0.5)), random.vec(1)};
    factor.lens = lens;
    for (int i = 0; i < kFrameSize * kFrameSize; ++i) factor.A.data()[i] = random.gauss(1);
    for (int i = 0; i < kFrameSize; ++i) factor.c[i] = random.gauss(1);
    expect_derivatives(FrameCost(factor, 2.005, 1.5, 2.0, 0.02), x);
  }
}

}  // namespace
}  // namespace pirvs::tools
