// What    The trace of a run as a file that ui.perfetto.dev and chrome://tracing open.
// In      core/trace after the run: the last kTraceEventsMax scopes.
// Out     Chrome's trace event JSON, one lane per task, times in microseconds of bsp::now.
// Errors  none.
// Source  Chrome's "Trace Event Format", complete events.
#pragma once

#include <string>

namespace pirvs::tools {

std::string trace_json();

}  // namespace pirvs::tools
