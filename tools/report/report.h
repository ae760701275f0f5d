// What    The page about a run: trajectory over ground truth, errors, velocity, biases, timing,
//         health, counters, memory.
// In      Recording, RunLog, RunResult, RunInfo. `viewer`: a page that shows the run in 3-D
//         (tools/view/recorded_page.h), to stand in this one; empty: none.
// Out     One self-contained HTML document: nothing is loaded when it is viewed.
// Frames  With ground truth everything is drawn in its world (aligned), else in the estimator's.
// Units   as labelled.
// Errors  none.
// Cost    ~20 ms and ~500 kB for a minute of EuRoC; with a viewer 1.5 MB more.
// Source  DESIGN.md, "The front door" (report.html); Table II of the PIRVS paper.
#pragma once

#include <string>

#include "tools/run/files.h"
#include "tools/run/result.h"

namespace pirvs::tools {

std::string make_report(const RunInfo& info, const Recording& recording, const RunLog& log,
                        const RunResult& result, const std::vector<Count>& player_rejected,
                        const std::string& viewer = "");

}  // namespace pirvs::tools
