#include "core/store/lending.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "core/store/ring.h"

namespace pirvs {
namespace {

struct Item {};

TEST(lending, the_last_holder_is_told_and_the_slot_comes_back) {
  Lending<Item, 2> lending;
  const Handle<Item> a = lending.lend().value();
  lending.retain(a);
  lending.retain(a);
  EXPECT_FALSE(lending.release(a));
  EXPECT_FALSE(lending.release(a));
  EXPECT_TRUE(lending.release(a));
  EXPECT_EQ(lending.lent(), 1u) << "the last holder may still tidy up";
  lending.recycle(a);
  EXPECT_EQ(lending.lent(), 0u);
  const Handle<Item> b = lending.lend().value();
  EXPECT_EQ(a.slot, b.slot);
  EXPECT_NE(a, b);
}

TEST(lending, slots_come_back_in_any_order_and_none_is_lent_twice) {
  Lending<Item, 3> lending;
  Handle<Item> held[3];
  for (Handle<Item>& handle : held) handle = lending.lend().value();
  EXPECT_EQ(lending.lend().status(), Status::kFull);
  ASSERT_TRUE(lending.release(held[1]));
  EXPECT_EQ(lending.lend().status(), Status::kFull) << "not recycled yet";
  lending.recycle(held[1]);
  EXPECT_EQ(lending.lend().value().slot, held[1].slot);
  EXPECT_EQ(lending.lend().status(), Status::kFull);
}

TEST(lending, stops_on_handles_that_are_not_lent) {
  Lending<Item, 2> lending;
  EXPECT_DEATH(lending.retain({}), "bug");
  const Handle<Item> a = lending.lend().value();
  EXPECT_DEATH(lending.recycle(a), "bug") << "somebody holds it";
  ASSERT_TRUE(lending.release(a));
  EXPECT_DEATH((void)lending.release(a), "bug");
  EXPECT_DEATH(lending.retain(a), "bug") << "too late";
  lending.recycle(a);
  (void)lending.lend();
  EXPECT_DEATH((void)lending.release(a), "bug") << "of the tenant before";
}

// One core fills slots; two others read them, one of them later. Under the thread sanitizer this
// also says that a slot is filled again only after the last look at it.
TEST(lending, holders_on_several_cores_never_see_a_slot_change) {
  constexpr size_t kSlots = 4;
  constexpr uint64_t kItems = 20'000;
  struct Lent {
    Handle<Item> handle;
    uint64_t value;
  };
  Lending<Item, kSlots> lending;
  uint64_t content[kSlots] = {};
  Ring<Lent, 8> rings[2];
  uint64_t wrong[2] = {0, 0};
  std::vector<std::thread> readers;
  for (int r = 0; r < 2; ++r) {
    readers.emplace_back([&, r] {
      for (uint64_t i = 0; i < kItems; ++i) {
        const Lent* lent = nullptr;
        while ((lent = rings[r].front()) == nullptr) std::this_thread::yield();
        wrong[r] += content[lent->handle.slot] != lent->value;
        if (lending.release(lent->handle)) {
          content[lent->handle.slot] = 0;
          lending.recycle(lent->handle);
        }
        rings[r].pop();
      }
    });
  }
  for (uint64_t i = 1; i <= kItems; ++i) {
    auto handle = lending.lend();
    for (; !handle.ok(); handle = lending.lend()) std::this_thread::yield();
    content[handle.value().slot] = i;
    lending.retain(handle.value());
    for (auto& ring : rings) {
      while (!ring.push({handle.value(), i})) std::this_thread::yield();
    }
  }
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong[0] + wrong[1], 0u);
  EXPECT_EQ(lending.lent(), 0u);
}

}  // namespace
}  // namespace pirvs
