// What    The clip's first seconds, and its calibration as a file: what recordings in other forms
//         are made of and compared with.
// In      clip() is there.
#pragma once

#include <string>

#include "tools/dataset/recording.h"

namespace pirvs::systems {

inline constexpr double kPart_s = 5;

tools::Recording first_part();
// Reads back to the bit.
std::string calibration_file(const std::string& folder);

}  // namespace pirvs::systems
