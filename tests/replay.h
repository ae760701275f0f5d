// Runs the whole stack on a recording inside the test's own process, as `pirvs run` does.
// In      A Recording, which a test may have changed in memory; the number of cores; faults.
// Out     What the run has told, its result, and what the player rejected.
// Frames  as in tools/run.
// Errors  A run that takes longer than kReplay_s_max ends the process by SIGALRM: it hangs.
// Cost    ~2 ms a stereo frame, decoding beside it.
// Source  DESIGN, "The front door".
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/dataset/recording.h"
#include "tools/run/playback.h"
#include "tools/run/result.h"

namespace pirvs::systems {

// On a machine that others load, too; the thread sanitizer makes a run 60 times as long.
#ifdef __SANITIZE_THREAD__
inline constexpr unsigned kReplay_s_max = 1800;
#else
inline constexpr unsigned kReplay_s_max = 120;
#endif

struct Replay {
  Status status;
  tools::RunLog log;
  tools::RunResult result;
  std::vector<tools::Count> rejected;
  std::vector<tools::Count> faults;

  size_t counter(const std::string& name) const;  // of the stack or the player; asserts if unknown
  size_t applied(const std::string& spec) const;  // items that this fault changed
  std::string trajectory() const;                 // as trajectory.tum
  double first_pose_s() const;                    // after the first frame; infinite: never
  double ate_of_path() const;                     // ATE rmse as a share of the path
};

struct ReplayOptions {
  int cores = 1;
  std::vector<std::string> faults = {};  // as --fault takes them
  tools::Playback playback = tools::Playback::kFast;
  int mapping_lag = -1;  // as --mapping-lag, -1: without
  double camera_latency_s = 0;
  bool estimate_time = false, estimate_wheels = false;
  std::string record = {};                   // a folder, as --record
  std::string save_map = {}, load_map = {};  // as those of `pirvs run`
  bool extend_map = true;
  std::function<void(App&)> while_it_runs = {};  // on a thread of its own
};

Replay replay(const tools::Recording& recording, const ReplayOptions& options = {});

// No counter that means a failure of ours has counted, whatever the input was like.
void expect_no_failures(const Replay& replay);

// One line for people: what was measured.
void print(const char* what, const Replay& replay);

}  // namespace pirvs::systems
