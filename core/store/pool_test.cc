#include "core/store/pool.h"

#include <gtest/gtest.h>

namespace pirvs {
namespace {

struct Item {
  int value = 5;
};

TEST(Pool, FindsLiveHandlesOnly) {
  Pool<Item, 2> pool;
  EXPECT_EQ(pool.find({}), nullptr);
  const Handle<Item> a = pool.acquire().value();
  ASSERT_NE(pool.find(a), nullptr);
  EXPECT_TRUE(a.valid());
  EXPECT_TRUE(pool.release(a));
  EXPECT_EQ(pool.find(a), nullptr);
  EXPECT_FALSE(pool.release(a));
  EXPECT_EQ(pool.size(), 0u);
}

TEST(Pool, StaleHandleMissesTheNextTenant) {
  Pool<Item, 2> pool;
  const Handle<Item> a = pool.acquire().value();
  pool.find(a)->value = 9;
  EXPECT_TRUE(pool.release(a));
  const Handle<Item> b = pool.acquire().value();
  EXPECT_EQ(a.slot, b.slot);
  EXPECT_NE(a, b);
  EXPECT_EQ(pool.find(a), nullptr);
  ASSERT_NE(pool.find(b), nullptr);
  EXPECT_EQ(pool.find(b)->value, 5) << "acquire initializes the object again";
}

TEST(Pool, IsFullAtItsCapacityAndReusesEverySlot) {
  Pool<Item, 3> pool;
  for (int round = 0; round < 4; ++round) {
    Handle<Item> handles[3];
    for (Handle<Item>& handle : handles) handle = pool.acquire().value();
    EXPECT_EQ(pool.acquire().status(), Status::kFull);
    EXPECT_EQ(pool.size(), 3u);
    // Release in an order that differs by round.
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(pool.release(handles[(i * 2 + round) % 3]));
  }
  EXPECT_EQ(pool.size(), 0u);
}

TEST(Pool, WalksItsLiveSlots) {
  Pool<Item, 4> pool;
  Handle<Item> handles[4];
  for (Handle<Item>& handle : handles) handle = pool.acquire().value();
  EXPECT_TRUE(pool.release(handles[2]));
  size_t live = 0;
  for (size_t slot = 0; slot < pool.capacity(); ++slot) {
    if (pool.at(slot) == nullptr) {
      EXPECT_EQ(slot, handles[2].slot);
      EXPECT_FALSE(pool.handle(slot).valid());
      continue;
    }
    ++live;
    EXPECT_EQ(pool.find(pool.handle(slot)), pool.at(slot));
  }
  EXPECT_EQ(live, pool.size());
}

TEST(Pool, RejectsForgedHandles) {
  Pool<Item, 2> pool;
  (void)pool.acquire();
  EXPECT_EQ(pool.find({1, 7}), nullptr);
  EXPECT_EQ(pool.find({0, 0}), nullptr);
  EXPECT_EQ(pool.find({0, 1}), nullptr);
}

}  // namespace
}  // namespace pirvs
