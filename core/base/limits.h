// The limits that every part of the stack shares; a board asserts that its sensors fit.
#pragma once

namespace pirvs {

inline constexpr int kCamerasMax = 2;
inline constexpr int kImageWidthMax = 752;   // EuRoC's MT9V034; the device's OV7251 has 640
inline constexpr int kImageHeightMax = 480;  // both

}  // namespace pirvs
