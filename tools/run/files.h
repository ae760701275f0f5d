// What    Writes a run's files: trajectory.tum, keyframes.tum, map.ply, timing.csv, summary.json.
// In      The folder (made if it is not there), Recording, RunLog, RunResult.
// Out     the files, as DESIGN.md describes them.
// Frames  T_WB; points in W.
// Errors  InputError if a file cannot be written.
// Source  DESIGN.md, "The front door".
#pragma once

#include <string>

#include "tools/run/result.h"

namespace pirvs::tools {

struct RunInfo {
  std::string command;  // as typed
  std::string sequence;
  std::string revision;  // of the source tree that the program lies in
  int cores = 1;
};

void make_output_folder(const std::string& folder);
void write_file(const std::string& path, const std::string& content);
void write_run_files(const std::string& folder, const RunInfo& info, const Recording& recording,
                     const RunLog& log, const RunResult& result,
                     const std::vector<Count>& player_rejected);

// What `git describe` says where the program lies; "unknown" outside a repository.
std::string source_revision();

}  // namespace pirvs::tools
