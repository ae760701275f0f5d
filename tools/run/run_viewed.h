// What    `pirvs view SEQ`: a run in real time for a page, which leaves no files.
// In      The view; the recording; how.
// Out     The exit status of `pirvs run`; kExitSignal and above: ended by hand.
// Errors  InputError, as `pirvs run`.
// Source  docs/view.md.
#pragma once

#include <string>
#include <vector>

#include "tools/dataset/recording.h"
#include "tools/view/view.h"

namespace pirvs::tools {

struct ViewedRun {
  RecordingOptions recording;
  int cores = 2;
  std::string files;  // folder of `map save` and `map load`; empty: the working directory
  std::string load_map;
  std::vector<std::string> set;
};

int run_viewed(View& view, const std::string& sequence, const ViewedRun& how);

}  // namespace pirvs::tools
