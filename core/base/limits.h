// The largest sensor set that the static memory is laid out for; a board states its own and asserts
// that it fits.
// Errors  none; what exceeds a limit is rejected where it enters (calibration, sensor door).
// Cost    Image pools grow with width x height x cameras.
// Source  DESIGN: EuRoC 752 x 480 stereo; the device 640 x 480 stereo.
#pragma once

namespace pirvs {

inline constexpr int kImageWidthMax = 752;
inline constexpr int kImageHeightMax = 480;
inline constexpr int kCamerasMax = 2;

}  // namespace pirvs
