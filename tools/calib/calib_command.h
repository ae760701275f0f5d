// What    The commands below `pirvs calib`, one file each.
// In, Out as tools/cli/command.h.
// Errors  likewise.
#pragma once

#include "tools/cli/command.h"

namespace pirvs::tools {

extern const Command kCalibTargetCommand;
extern const Command kCalibCornersCommand;
extern const Command kCalibCamerasCommand;
extern const Command kCalibImuCameraCommand;
extern const Command kCalibNoiseCommand;
extern const Command kCalibDeviceCommand;
extern const Command kCalibCheckCommand;
extern const Command kCalibBatchCommand;
extern const Command kCalibSimulateCommand;

}  // namespace pirvs::tools
