// What pirvsd is told: its command line, its configuration file, its calibration.
// In      argv as main() has it; has_isps: whether the board has image processors (isp:0).
// Out     Settings that are whole; the calibration, with what the settings say of the antenna.
// Errors  false: it cannot be, and one line on standard error has said where and why.
// Source  docs/device.md.
#pragma once

#include "board/linux/settings.h"
#include "modules/calibration/calibration.h"

namespace pirvs::board {

bool read_config(const char* path, Settings& out);
bool read_command_line(int argc, char** argv, bool has_isps, Settings& out);
bool read_device_calibration(const Settings& settings, Calibration& calibration);

}  // namespace pirvs::board
