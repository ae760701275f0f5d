#include "modules/mapping/robust_cost.h"

#include <gtest/gtest.h>

namespace pirvs {
namespace {

TEST(robust_cost, weight_is_the_derivative) {
  RobustCost robust;
  robust.begin(2.3);
  for (const double s : {0.0, 0.5, 2.0, 9.0, 100.0}) {
    const double slope = (robust.cost(s + 1e-6) - robust.cost(s)) / 1e-6;
    EXPECT_NEAR(robust.weight(s), slope, 1e-5) << s;
  }
  EXPECT_DOUBLE_EQ(robust.weight(0), 1);
  EXPECT_LT(robust.cost(1e9), 2.3 * 2.3);
}

TEST(robust_cost, small_residuals_leave_it_as_it_is) {
  RobustCost plain, robust;
  plain.begin(2);
  robust.begin(2);
  for (int i = 0; i < 60; ++i) robust.measure(0.01 * i);
  for (int i = 0; i < 40; ++i) robust.measure(1e4);  // outliers, but fewer than half
  robust.settle();
  EXPECT_EQ(robust.cost(3), plain.cost(3));
}

TEST(robust_cost, widens_where_most_are_far_off) {
  RobustCost robust;
  robust.begin(2);
  for (int i = 0; i < 100; ++i) robust.measure(36);  // 6 sigmas, all of them
  robust.settle();
  EXPECT_GT(robust.weight(36), 0.5);
  EXPECT_LT(robust.weight(36), 0.9);
}

TEST(robust_cost, without_residuals_and_with_endless_ones) {
  RobustCost robust;
  robust.begin(2);
  robust.settle();
  EXPECT_DOUBLE_EQ(robust.weight(4), 0.25);
  robust.begin(2);
  robust.measure(1e300);
  robust.settle();
  EXPECT_GT(robust.weight(4), 0.9);
}

}  // namespace
}  // namespace pirvs
