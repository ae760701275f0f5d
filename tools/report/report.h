// What    The page about a run: trajectory over ground truth, errors, velocity, biases, timing,
//         health, counters, memory.
// In      Recording, RunLog, RunResult, RunInfo.
// Out     One self-contained HTML document: nothing is loaded when it is viewed.
// Frames  With ground truth everything is drawn in its world (aligned), else in the estimator's.
// Units   as labelled.
// Errors  none.
// Cost    ~20 ms and ~500 kB for a minute of EuRoC.
// Source  DESIGN.md, "The front door" (report.html); Table II of the PIRVS paper.
#pragma once

#include <string>

#include "tools/run/files.h"
#include "tools/run/result.h"

namespace pirvs::tools {

std::string make_report(const RunInfo& info, const Recording& recording, const RunLog& log,
                        const RunResult& result, const std::vector<Count>& player_rejected);

}  // namespace pirvs::tools
