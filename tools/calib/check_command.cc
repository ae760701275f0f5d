// `pirvs calib check`: has this device been bumped? From any flight, no board.
#include <cmath>
#include <cstdio>
#include <memory>

#include "tools/calib/calib_command.h"
#include "tools/calib/flight_check.h"
#include "tools/dataset/recording_options.h"

namespace pirvs::tools {
namespace {

struct Options {
  std::string sequence, calibration;
};

int run(const Options& o) {
  RecordingOptions how;
  how.calibration = o.calibration;
  const Recording recording = open_recording(o.sequence, how);
  print_notes(recording);
  const FlightVerdict verdict = judge(follow(recording), recording.imu, recording.calibration);
  std::printf("%zu looks, %zu points, %.2f px\n", verdict.looks, verdict.points,
              verdict.residual_px);
  for (const FlightFinding& f : verdict.findings) {
    const char* const state = f.bumped()                    ? "  BUMPED"
                              : !f.told()                   ? "  not told by this flight"
                              : std::abs(f.value) > f.limit ? "  in doubt"
                                                            : "";
    std::printf("%-42s %8.3f +- %.3f %s, limit %g%s\n", f.what.c_str(), f.value, f.sigma,
                f.unit.c_str(), f.limit, state);
  }
  std::printf(verdict.bumped() ? "the device is not as its calibration says: calibrate it again\n"
                               : "the calibration holds\n");
  return verdict.bumped() ? kExitFailed : kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("SEQ", o->sequence, "a recording: any flight, with turns and texture")->required();
  app.add_option("CALIB", o->calibration, "the calibration in question; else the recording's own");
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibCheckCommand = {"check", "Has this device been bumped? From any flight",
                                    declare};

}  // namespace pirvs::tools
