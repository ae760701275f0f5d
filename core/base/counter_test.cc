#include "core/base/counter.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

namespace pirvs {
namespace {

struct Counters {
  Counter taken, left;
};
constexpr CounterRow<Counters> kRows[] = {{"taken", &Counters::taken}, {"left", &Counters::left}};
static_assert(every_counter_is_in(kRows));
constexpr CounterRow<Counters> kTwice[] = {{"taken", &Counters::taken}, {"left", &Counters::taken}};
static_assert(!every_counter_is_in(kTwice));
constexpr CounterRow<Counters> kOne[] = {{"taken", &Counters::taken}};
static_assert(!every_counter_is_in(kOne));

enum class Loss : uint8_t { kEarly, kLate, kCount };
const char* name(Loss loss) { return loss == Loss::kEarly ? "early" : "late"; }

TEST(counter, rows_and_enums_give_names_and_values) {
  Counters counters;
  ++counters.taken;
  counters.left += 7;
  CounterArray<Loss> losses, more;
  losses.add(Loss::kLate);
  more.add(Loss::kLate);
  more.add(Loss::kEarly);
  losses += more;
  std::string text;
  const auto visit = [&text](const char* what, uint32_t value) {
    text += std::string(what) + " " + std::to_string(value) + ",";
  };
  for_each_counter(counters, kRows, visit);
  for_each_counter(losses, visit);
  EXPECT_EQ(text, "taken 1,left 7,early 1,late 2,");
  EXPECT_EQ(losses[Loss::kLate], 2u);
}

TEST(counter, counts_from_several_cores_while_another_reads) {
  constexpr uint32_t kEach = 20'000;
  Counters counters;
  const auto count = [&] {
    for (uint32_t i = 0; i < kEach; ++i) ++counters.taken;
  };
  std::thread one(count), two(count);
  for (uint32_t last = 0; last < 2 * kEach;) {
    const uint32_t now = counters.taken;
    ASSERT_GE(now, last);
    last = now;
  }
  one.join();
  two.join();
  EXPECT_EQ(counters.taken, 2 * kEach);
}

TEST(counter, copies_and_keeps_the_largest) {
  BasicCounter<int64_t> longest;
  longest.raise_to(5);
  longest.raise_to(3);
  const BasicCounter<int64_t> copy = longest;
  longest = BasicCounter<int64_t>{};
  EXPECT_EQ(copy, 5);
  EXPECT_EQ(longest, 0);
}

}  // namespace
}  // namespace pirvs
