// `pirvs calib batch`: a night's recordings, several at once, one table.
#include <cstdio>
#include <memory>

#include "tools/calib/batch.h"
#include "tools/calib/calib_command.h"

namespace pirvs::tools {
namespace {

int run(const BatchOptions& o) {
  size_t passed = 0;
  const std::vector<BatchRow> rows = run_batch(o, [](const BatchRow& row) {
    std::printf("%-20s %-8s %6.1f s  %s%s\n", row.serial.c_str(), verdict_name(row.verdict),
                row.seconds, row.kept ? "(from before) " : "", row.reason.c_str());
    std::fflush(stdout);
  });
  for (const BatchRow& row : rows) passed += row.verdict == Verdict::kPassed;
  std::printf("%zu of %zu passed, written: %s/batch.csv, batch.html\n", passed, rows.size(),
              o.out.c_str());
  return passed == rows.size() ? kExitDone : kExitFailed;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<BatchOptions>();
  app.add_option("DIR", o->folder, "a folder with one recording a device, by serial number")
      ->required();
  app.add_option("--target", o->target, "the board's yaml")->required()->check(CLI::ExistingFile);
  app.add_option("--out", o->out, "folder for a folder a device, batch.csv and batch.html")
      ->required();
  app.add_option("--jobs", o->jobs, "devices at once; else one for every two cores")
      ->check(CLI::Range(1, 1024));
  app.add_flag("--again", o->again, "calibrate those anew that have an outcome.json");
  app.add_option("--device-options", o->more, "options that each `calib device` gets, in one word")
      ->delimiter(' ');
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibBatchCommand = {
    "batch", "A night's devices: each calibrated on its own, several at once, one table", declare};

}  // namespace pirvs::tools
