#include "board/bare/profile.h"

#include <cstring>
#include <iterator>

#include "bsp/api/console.h"
#include "bsp/api/cycles.h"
#include "core/base/text.h"
#include "core/trace/trace.h"

namespace pirvs::board {
namespace {

// Core/trace measures by any clock; here it counts cycles. A scope begins and ends on one core.
TimeNs cycle_clock() { return static_cast<TimeNs>(bsp::read_cycles().cycles); }

enum Column : int { kImage, kMatching, kTracking, kMapping, kColumns };
constexpr const char* kLabels[] = {"Image Processing", "Matching", "Tracking", "Mapping"};
static_assert(std::size(kLabels) == kColumns);

struct Totals {
  int64_t cycles[kColumns] = {};
};

// What a task adds to a column. Matching runs inside of tracking, so it is taken out there.
struct Share {
  const char* place;
  Column column;
  int64_t factor;
};
constexpr Share kShares[] = {
    {"frontend", kImage, 1},    {"matching", kMatching, 1},   {"matching", kTracking, -1},
    {"tracking", kTracking, 1}, {"door.frame", kTracking, 1}, {"imu", kTracking, 1},
    {"mapping", kMapping, 1},
};

void say(TextWriter& line) {
  line.put('\n');
  bsp::console_write(line.c_str());
  line.clear();
}

void say_place(void* context, const TracePlace& place) {
  Totals& totals = *static_cast<Totals*>(context);
  const int64_t total = place.total.load(std::memory_order_relaxed);
  const uint64_t runs = place.runs.load(std::memory_order_relaxed);
  for (const Share& share : kShares) {
    if (std::strcmp(share.place, place.name) != 0) continue;
    totals.cycles[share.column] += share.factor * total;
  }
  Text<160> line;
  line.put("profile task ").put(place.name).put(' ').unsigned_number(runs).put(" runs, mean ");
  line.number(total / static_cast<int64_t>(runs)).put(", longest ");
  line.number(place.longest.load(std::memory_order_relaxed)).put(" cycles");
  say(line);
}

}  // namespace

void profile_start() { trace_start(cycle_clock); }

void profile_say(uint32_t frames) {
  if (frames == 0) return;
  Text<160> line;
  line.put(bsp::cycles_are_real()
               ? "profile: cycles counted by the processor (PMU)"
               : "profile: cycles counted by an emulator: one an instruction, all cores together");
  say(line);
  Totals totals;
  trace_places(&totals, say_place);
  int64_t sum = 0;
  for (int c = 0; c < kColumns; ++c) {
    sum += totals.cycles[c];
    line.put("profile ").put(kLabels[c]).put(' ').number(totals.cycles[c] / frames);
    line.put(" cycles a frame");
    say(line);
  }
  line.put("profile End-to-End ").number(sum / frames).put(" cycles a frame");
  say(line);
}

}  // namespace pirvs::board
