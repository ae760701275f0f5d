// What    Reads what the wheels of a vehicle told.
// In      A table as in an ASL folder's wheel0/data.csv: timestamp and two values, as `kind` says:
//         left, right [m/s]; speed [m/s], turn [rad/s]; left, right [counts]; speed [m/s], steering
//         [rad].
// Out     Samples in order of time.
// Errors  InputError: a file that cannot be read, a line that is no data, no samples. Rejected and
//         counted by name: rows cut off, not finite, not after the row before.
// Source  docs/gnss.md, "Wheels".
#pragma once

#include <string>
#include <vector>

#include "modules/wheels/wheel_sample.h"
#include "tools/dataset/input_log.h"

namespace pirvs::tools {

std::vector<WheelSample> read_wheels(const std::string& path, WheelKind kind, InputLog& log);

}  // namespace pirvs::tools
