#include "core/store/fixed_vector.h"

#include <gtest/gtest.h>

namespace pirvs {
namespace {

TEST(FixedVector, RejectsBeyondItsCapacity) {
  FixedVector<int, 3> v;
  EXPECT_TRUE(v.empty());
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(v.push_back(i));
  EXPECT_TRUE(v.full());
  EXPECT_FALSE(v.push_back(3));
  EXPECT_EQ(v.append(), nullptr);
  EXPECT_EQ(v.size(), 3u);
  EXPECT_EQ(v.back(), 2);
}

TEST(FixedVector, ErasesByMovingTheLastItem) {
  FixedVector<int, 4> v;
  for (int i = 0; i < 4; ++i) *v.append() = i;
  v.erase_unordered(1);
  ASSERT_EQ(v.size(), 3u);
  EXPECT_EQ(v[1], 3);
  v.erase_unordered(2);
  v.pop_back();
  ASSERT_EQ(v.size(), 1u);
  EXPECT_EQ(v[0], 0);
}

TEST(FixedVector, IteratesAndResizes) {
  FixedVector<int, 4> v;
  v.resize(4);
  for (int& item : v) item = 7;
  v.resize(2);
  int sum = 0;
  for (int item : v) sum += item;
  EXPECT_EQ(sum, 14);
  v.clear();
  EXPECT_TRUE(v.empty());
}

TEST(FixedVector, StopsOnAWrongIndex) {
  FixedVector<int, 2> v;
  EXPECT_DEATH(v[0], "bug");
  EXPECT_DEATH(v.back(), "bug");
  EXPECT_DEATH(v.pop_back(), "bug");
  EXPECT_DEATH(v.resize(3), "bug");
}

}  // namespace
}  // namespace pirvs
