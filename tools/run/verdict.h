// What    Says in one line why a run did not end as it should: it never started, tracking was lost,
//         or the last pose is one to be doubted.
// In      the recording and what its run has told.
// Out     empty: tracking to the last frame, and nothing to doubt.
// Errors  none.
// Source  docs/health.md.
#pragma once

#include <string>

#include "tools/dataset/recording.h"
#include "tools/run/run_log.h"

namespace pirvs::tools {

std::string verdict(const Recording& recording, const RunLog& log);

// Their names, apart by '+'; empty: none.
std::string reasons_text(uint16_t reasons);

}  // namespace pirvs::tools
