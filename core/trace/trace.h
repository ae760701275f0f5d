// Where the time goes: a ring of the last scopes, and totals per place in the code.
// In      trace_start(clock) once, before other cores run; PIRVS_TRACE("name") at the top of a
//         scope, with a literal.
// Out     trace_events: the last kTraceEventsMax scopes, in the order in which they ended.
//         trace_places: every place that has run, with count, total and longest time.
// Units   ns, of the clock that was passed in.
// Errors  Older events are overwritten. Read when the other cores are at rest: a scope that ends
//         meanwhile may be seen half written.
// Cost    Two clock readings and five atomic operations a scope, 90 ns on x86-64 Linux with
//         bsp::now; one load and two marks before trace_start. Always compiled in; not for jobs
//         below 10 us.
// Source  STYLE principle 10: the clock comes in as an argument.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/time.h"

namespace pirvs {

struct TraceEvent {
  const char* name;
  TimeNs begin;
  TimeNs end;
};

// One PIRVS_TRACE in the code. Links itself into the list of places when it first runs.
struct TracePlace {
  constexpr explicit TracePlace(const char* place_name) : name(place_name) {}

  std::atomic<uint8_t> mark{0};  // first: tools/prof finds the name behind it
  const char* name;
  std::atomic<uint64_t> runs{0};
  std::atomic<int64_t> total{0};
  std::atomic<int64_t> longest{0};
  std::atomic<bool> listed{false};
  TracePlace* next = nullptr;
};

inline constexpr size_t kTraceEventsMax = 4096;  // 96 KiB: about 10 s of a 20 Hz stereo pipeline

void trace_start(TimeNs (*clock)());  // forgets earlier events and totals; nullptr: off
void trace_events(void* context, void (*visit)(void* context, const TraceEvent& event));
void trace_places(void* context, void (*visit)(void* context, const TracePlace& place));

// What an observer outside the program sees of a scope, whether or not the clock is on: a call of
// these, each a single store to place.mark (tools/prof/plugin.c watches for it).
void trace_mark_begin(TracePlace& place);
void trace_mark_end(TracePlace& place);

class TraceScope {
 public:
  explicit TraceScope(TracePlace& place);
  ~TraceScope();
  TraceScope(const TraceScope&) = delete;
  TraceScope& operator=(const TraceScope&) = delete;

 private:
  TracePlace& place_;
  TimeNs (*clock_)();
  TimeNs begin_ = 0;
};

}  // namespace pirvs

#define PIRVS_TRACE(name)                             \
  static ::pirvs::TracePlace pirvs_trace_place{name}; \
  const ::pirvs::TraceScope pirvs_trace_scope(pirvs_trace_place)
