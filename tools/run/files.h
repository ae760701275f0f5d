// What    Writes a run's files: trajectory.tum, state.csv, keyframes.tum, map.ply, timing.csv,
//         nees.csv, summary.json.
// In      The folder (made if it is not there), Recording, RunLog, RunResult.
// Out     the files, as DESIGN.md describes them: each is written as NAME.part, and all get their
//         names once the last one is complete.
// Frames  T_WB; points in W.
// Errors  InputError if a file cannot be written; then none is left and older ones stay.
// Source  DESIGN.md, "The front door".
#pragma once

#include <string>
#include <vector>

#include "tools/run/result.h"

namespace pirvs::tools {

struct RunInfo {
  std::string command;  // as typed
  std::string sequence;
  std::string revision;  // the program's, core/base/version.h
  int cores = 1;
  std::vector<Count> faults;  // put in by hand, and how many items each has changed
};

class OutputFolder {
 public:
  static constexpr const char* kPart = ".part";  // of a name that is written, not yet given
  // Fails at once where nothing could be written at the end, where another run writes, and, unless
  // forced, where results are already.
  explicit OutputFolder(const std::string& folder, bool force = false);
  ~OutputFolder();  // removes what was not committed
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  void write(const std::string& name, const std::string& content);
  void commit();

 private:
  std::string folder_;
  int lock_ = -1;                   // held as long as this writes
  std::vector<std::string> parts_;  // names written, not yet given
};

void write_run_files(OutputFolder& out, const RunInfo& info, const Recording& recording,
                     const RunLog& log, const RunResult& result,
                     const std::vector<Count>& player_rejected);

}  // namespace pirvs::tools
