// `pirvs calib ...`: factory calibration.
#include "tools/calib/calib_command.h"

#include <utility>
#include <vector>

#include "tools/cli/command.h"

namespace pirvs::tools {
namespace {

const Command* const kSteps[] = {
    &kCalibTargetCommand,    &kCalibCornersCommand, &kCalibCamerasCommand,
    &kCalibImuCameraCommand, &kCalibNoiseCommand,   &kCalibDeviceCommand,
    &kCalibBatchCommand,     &kCalibCheckCommand,   &kCalibSimulateCommand};

std::function<int()> declare(CLI::App& app) {
  app.require_subcommand(1);
  std::vector<std::pair<CLI::App*, std::function<int()>>> runs;
  for (const Command* step : kSteps) {
    CLI::App* options = app.add_subcommand(step->name, step->help);
    runs.emplace_back(options, step->declare(*options));
  }
  return [runs] {
    for (const auto& [options, run] : runs) {
      if (options->parsed()) return run();
    }
    return kExitBadInput;
  };
}

}  // namespace

const Command kCalibCommand = {"calib", "Calibrate a device: cameras, IMU, noise", declare};

}  // namespace pirvs::tools
