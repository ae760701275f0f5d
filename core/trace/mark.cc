// In a file of their own, so that they are never inlined: an observer knows them by their address.
#include "core/trace/trace.h"

namespace pirvs {

void trace_mark_begin(TracePlace& place) { place.mark.store(1, std::memory_order_relaxed); }
void trace_mark_end(TracePlace& place) { place.mark.store(0, std::memory_order_relaxed); }

}  // namespace pirvs
