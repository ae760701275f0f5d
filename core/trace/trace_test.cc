#include "core/trace/trace.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <thread>
#include <vector>

namespace pirvs {
namespace {

std::atomic<TimeNs> fake_time{0};
TimeNs tick() { return fake_time += 10; }

void inner() { PIRVS_TRACE("inner"); }

void outer() {
  PIRVS_TRACE("outer");
  inner();
  inner();
}

struct Totals {
  uint64_t runs;
  int64_t total, longest;
};

std::map<std::string, Totals> places() {
  std::map<std::string, Totals> out;
  trace_places(&out, [](void* context, const TracePlace& place) {
    (*static_cast<std::map<std::string, Totals>*>(context))[place.name] = {place.runs, place.total,
                                                                           place.longest};
  });
  return out;
}

std::vector<TraceEvent> ended() {
  std::vector<TraceEvent> out;
  trace_events(&out, [](void* context, const TraceEvent& event) {
    static_cast<std::vector<TraceEvent>*>(context)->push_back(event);
  });
  return out;
}

TEST(Trace, RecordsScopesAsTheyEndAndTotalsPerPlace) {
  fake_time = 0;
  trace_start(tick);
  outer();
  const std::vector<TraceEvent> events = ended();
  ASSERT_EQ(events.size(), 3u);
  EXPECT_STREQ(events[0].name, "inner");
  EXPECT_STREQ(events[2].name, "outer");
  EXPECT_EQ(events[2].begin, 10);
  EXPECT_EQ(events[2].end, 60);
  EXPECT_EQ(places().at("inner").runs, 2u);
  EXPECT_EQ(places().at("inner").total, 20);
  EXPECT_EQ(places().at("outer").longest, 50);
  trace_start(nullptr);
}

TEST(Trace, IsSilentWhenOffAndKeepsTheNewest) {
  trace_start(nullptr);
  outer();
  EXPECT_TRUE(ended().empty());
  EXPECT_TRUE(places().empty());
  trace_start(tick);
  for (size_t i = 0; i < kTraceEventsMax; ++i) inner();
  outer();
  EXPECT_EQ(ended().size(), kTraceEventsMax);
  EXPECT_STREQ(ended().back().name, "outer");
  trace_start(nullptr);
}

TEST(Trace, CountsFromTwoCores) {
  trace_start(tick);
  const auto work = [] {
    for (int i = 0; i < 1000; ++i) inner();
  };
  std::thread second(work);
  work();
  second.join();
  EXPECT_EQ(places().at("inner").runs, 2000u);
  trace_start(nullptr);
}

}  // namespace
}  // namespace pirvs
