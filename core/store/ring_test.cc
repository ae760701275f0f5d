#include "core/store/ring.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace pirvs {
namespace {

TEST(Ring, KeepsOrderAndItsLimit) {
  Ring<int, 3> ring;
  EXPECT_EQ(ring.front(), nullptr);
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(ring.push(10 * round + i));
    EXPECT_FALSE(ring.push(99));
    EXPECT_EQ(ring.begin_push(), nullptr);
    EXPECT_EQ(ring.size(), 3u);
    for (int i = 0; i < 3; ++i) {
      ASSERT_NE(ring.front(), nullptr);
      EXPECT_EQ(*ring.front(), 10 * round + i);
      ring.pop();
    }
    EXPECT_EQ(ring.size(), 0u);
  }
  EXPECT_DEATH(ring.pop(), "bug");
}

TEST(Ring, HandsEverythingOverBetweenTwoThreads) {
  struct Item {
    uint64_t a, b;
  };
  static Ring<Item, 7> ring;
  constexpr uint64_t kItems = 200'000;
  std::thread writer([] {
    for (uint64_t i = 0; i < kItems;) {
      Item* item = ring.begin_push();
      if (item == nullptr) {
        std::this_thread::yield();
        continue;
      }
      *item = {i, ~i};
      ring.end_push();
      ++i;
    }
  });
  uint64_t wrong = 0;
  for (uint64_t i = 0; i < kItems;) {
    const Item* item = ring.front();
    if (item == nullptr) {
      std::this_thread::yield();
      continue;
    }
    wrong += item->a != i || item->b != ~i;
    ring.pop();
    ++i;
  }
  writer.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(ring.size(), 0u);
}

}  // namespace
}  // namespace pirvs
