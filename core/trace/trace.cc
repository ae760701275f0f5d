#include "core/trace/trace.h"

#include <algorithm>

namespace pirvs {
namespace {

std::atomic<TimeNs (*)()> trace_clock{nullptr};
std::atomic<TracePlace*> first_place{nullptr};
std::atomic<size_t> events_ended{0};
TraceEvent events[kTraceEventsMax];

void list(TracePlace& place) {
  if (place.listed.exchange(true, std::memory_order_relaxed)) return;
  place.next = first_place.load(std::memory_order_relaxed);
  while (!first_place.compare_exchange_weak(place.next, &place, std::memory_order_release,
                                            std::memory_order_relaxed)) {
  }
}

void record(TracePlace& place, TimeNs begin, TimeNs end) {
  const size_t slot = events_ended.fetch_add(1, std::memory_order_relaxed) % kTraceEventsMax;
  events[slot] = {place.name, begin, end};
  place.runs.fetch_add(1, std::memory_order_relaxed);
  place.total.fetch_add(end - begin, std::memory_order_relaxed);
  int64_t longest = place.longest.load(std::memory_order_relaxed);
  while (end - begin > longest &&
         !place.longest.compare_exchange_weak(longest, end - begin, std::memory_order_relaxed)) {
  }
}

}  // namespace

void trace_start(TimeNs (*clock)()) {
  trace_clock.store(clock, std::memory_order_relaxed);
  events_ended.store(0, std::memory_order_relaxed);
  for (TracePlace* place = first_place.load(); place != nullptr; place = place->next) {
    place->runs = 0;
    place->total = 0;
    place->longest = 0;
  }
}

void trace_events(void* context, void (*visit)(void*, const TraceEvent&)) {
  const size_t ended = events_ended.load(std::memory_order_acquire);
  for (size_t i = ended - std::min(ended, kTraceEventsMax); i < ended; ++i) {
    visit(context, events[i % kTraceEventsMax]);
  }
}

void trace_places(void* context, void (*visit)(void*, const TracePlace&)) {
  for (const TracePlace* place = first_place.load(std::memory_order_acquire); place != nullptr;
       place = place->next) {
    if (place->runs.load(std::memory_order_relaxed) > 0) visit(context, *place);
  }
}

TraceScope::TraceScope(TracePlace& place)
    : place_(place), clock_(trace_clock.load(std::memory_order_relaxed)) {
  trace_mark_begin(place);
  if (clock_ == nullptr) return;
  list(place);
  begin_ = clock_();
}

TraceScope::~TraceScope() {
  if (clock_ != nullptr) record(place_, begin_, clock_());
  trace_mark_end(place_);
}

}  // namespace pirvs
