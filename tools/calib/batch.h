// What    Calibrates every device of a folder, several at once, each in a process of its own, and
//         says of each how it went.
// In      A folder with one recording a device, by serial number; the board; the program.
// Out     Of each device OUT/SERIAL: what `calib device` writes, log.txt, and outcome.json last of
//         all. A device that has one is not calibrated again: a batch that was stopped goes on.
//         OUT/batch.csv and OUT/batch.html: a row a device.
// Errors  InputError: no recordings, OUT cannot be written. A device that crashes is a row.
// Cost    what `calib device` costs, which has two threads.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace pirvs::tools {

struct BatchOptions {
  std::string folder, target, out;
  std::string program = "/proc/self/exe";
  int jobs = 0;  // 0: one for every two cores
  bool again = false;
  std::vector<std::string> more;  // options for `calib device`
};

enum class Verdict : uint8_t { kPassed, kFailed, kRefused, kCrashed };
const char* verdict_name(Verdict verdict);

struct BatchRow {
  std::string serial;
  Verdict verdict = Verdict::kCrashed;
  double seconds = 0;
  bool kept = false;   // from an earlier batch
  std::string reason;  // of what has not passed: one line
};

// told: each row as it comes, from one thread at a time. Rows by serial number.
std::vector<BatchRow> run_batch(const BatchOptions& options,
                                const std::function<void(const BatchRow&)>& told);

}  // namespace pirvs::tools
