// What    The clip's first seconds, and its calibration as a file: what recordings in other forms
//         are made of and compared with.
// In      clip() is there.
#pragma once

#include <string>

#include "tools/dataset/recording.h"

namespace pirvs::systems {

inline constexpr double kPart_s = 5;

tools::Recording first_part();
std::string calibration_file(const std::string& folder);
// As text to the digit, or one beside it: the calibration is read back to the last bit, or one
// beside it (core/base/number.h).
void expect_same_trajectory(const std::string& got, const std::string& wanted);

}  // namespace pirvs::systems
