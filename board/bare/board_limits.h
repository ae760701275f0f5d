// What the static memory of boards without an operating system is laid out for; core/base/limits.h
// includes it.
// Source  EuRoC 752 x 480 stereo; the device 640 x 480 stereo.
#pragma once

namespace pirvs {

inline constexpr int kImagePixelsMax = 752 * 480;
inline constexpr int kImageSideMax = 752;
inline constexpr int kPoolBytesMax = 32 << 20;

}  // namespace pirvs
