#include "core/store/mailbox.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <thread>

namespace pirvs {
namespace {

TEST(Mailbox, GivesTheNewestOnce) {
  Mailbox<int> box;
  EXPECT_EQ(box.take(), nullptr);
  for (int value = 1; value <= 3; ++value) {
    box.back() = value;
    box.publish();
  }
  const int* taken = box.take();
  ASSERT_NE(taken, nullptr);
  EXPECT_EQ(*taken, 3);
  EXPECT_EQ(box.take(), nullptr);
  // What was taken stays while the writer goes on.
  for (int value = 4; value <= 6; ++value) {
    box.back() = value;
    box.publish();
    EXPECT_EQ(*taken, 3);
  }
  EXPECT_EQ(*box.take(), 6);
}

TEST(Mailbox, NeverTearsBetweenTwoThreads) {
  struct Value {
    uint64_t words[32];
  };
  static Mailbox<Value> box;
  constexpr uint64_t kValues = 100'000;
  std::atomic<bool> done{false};
  std::thread writer([&done] {
    for (uint64_t i = 1; i <= kValues; ++i) {
      for (uint64_t& word : box.back().words) word = i;
      box.publish();
    }
    done.store(true);
  });
  uint64_t torn = 0, backwards = 0, last = 0;
  for (;;) {
    const bool finished = done.load();
    const Value* value = box.take();
    if (value == nullptr) {
      if (finished) break;
      std::this_thread::yield();
      continue;
    }
    for (const uint64_t word : value->words) torn += word != value->words[0];
    backwards += value->words[0] <= last;
    last = value->words[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backwards, 0u);
  EXPECT_EQ(last, kValues) << "the last value always arrives";
}

}  // namespace
}  // namespace pirvs
