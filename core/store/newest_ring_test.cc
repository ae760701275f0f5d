#include "core/store/newest_ring.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <thread>

namespace pirvs {
namespace {

template <size_t N>
void publish(NewestRing<int, N>& ring, int value) {
  ring.back() = value;
  ring.publish();
}

TEST(NewestRing, KeepsOrderAndTheNewest) {
  NewestRing<int, 3> ring;
  EXPECT_EQ(ring.take(), nullptr);
  int value = 0, expected = 1;
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < 2; ++i) publish(ring, ++value);
    for (int i = 0; i < 2; ++i) {
      const int* taken = ring.take();
      ASSERT_NE(taken, nullptr);
      EXPECT_EQ(*taken, expected++);
    }
    EXPECT_EQ(ring.take(), nullptr);
  }
  EXPECT_EQ(ring.lost(), 0u);
  for (int i = 0; i < 8; ++i) publish(ring, ++value);
  EXPECT_EQ(ring.lost(), 5u);
  for (int i = 2; i >= 0; --i) {
    const int* taken = ring.take();
    ASSERT_NE(taken, nullptr);
    EXPECT_EQ(*taken, value - i);
  }
  EXPECT_EQ(ring.take(), nullptr);
}

TEST(NewestRing, LeavesWhatWasTakenAlone) {
  NewestRing<int, 2> ring;
  publish(ring, 1);
  const int* taken = ring.take();
  ASSERT_NE(taken, nullptr);
  for (int value = 2; value < 20; ++value) {
    publish(ring, value);
    EXPECT_EQ(*taken, 1);
  }
  EXPECT_EQ(*ring.take(), 18);
  EXPECT_EQ(*ring.take(), 19);
  EXPECT_EQ(ring.take(), nullptr);
}

// A writer that never waits laps the reader again and again.
TEST(NewestRing, NeitherTearsNorMiscountsBetweenTwoThreads) {
  struct Value {
    uint64_t words[32];
  };
  static NewestRing<Value, 4> ring;
  constexpr uint64_t kValues = 100'000;
  std::atomic<bool> done{false};
  std::thread writer([&done] {
    for (uint64_t i = 1; i <= kValues; ++i) {
      for (uint64_t& word : ring.back().words) word = i;
      ring.publish();
      if (i % 64 == 0) std::this_thread::yield();
    }
    done.store(true);
  });
  uint64_t torn = 0, backwards = 0, last = 0, taken = 0;
  for (;;) {
    const bool finished = done.load();
    const Value* value = ring.take();
    if (value == nullptr) {
      if (finished) break;
      std::this_thread::yield();
      continue;
    }
    for (const uint64_t word : value->words) torn += word != value->words[0];
    backwards += value->words[0] <= last;
    last = value->words[0];
    ++taken;
  }
  writer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backwards, 0u);
  EXPECT_EQ(last, kValues) << "the newest always arrives";
  EXPECT_EQ(taken + ring.lost(), kValues);
}

}  // namespace
}  // namespace pirvs
