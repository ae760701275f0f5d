#include "core/base/status.h"

#include <gtest/gtest.h>

#include "core/base/time.h"

namespace pirvs {
namespace {

Result<int> half(int n) {
  if (n % 2 != 0) return Status::kBadData;
  return n / 2;
}

Status run(int n) {
  PIRVS_TRY(half(n).status());
  return Status::kEmpty;
}

TEST(Status, TryReturnsTheFirstFault) {
  EXPECT_EQ(run(3), Status::kBadData);
  EXPECT_EQ(run(4), Status::kEmpty);
  EXPECT_STREQ(name(run(3)), "bad data");
}

TEST(Status, ResultHoldsAValueOrAFault) {
  EXPECT_EQ(half(4).value(), 2);
  EXPECT_FALSE(half(5).ok());
  EXPECT_DEATH((void)half(5).value(), "bug");
}

TEST(Time, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(from_seconds(1.4e-9), 1);
  EXPECT_EQ(from_seconds(-1.6e-9), -2);
  EXPECT_EQ(from_seconds(0.1), 100'000'000);
  EXPECT_EQ(to_seconds(from_seconds(12.5)), 12.5);
  static_assert(from_seconds(0.005) == 5'000'000);
}

}  // namespace
}  // namespace pirvs
