// What the static memory of this board's build is laid out for: core/base/limits.h includes the
// board's own file of this name, found on the include path that the Makefile gives.
// Source  The largest sensors that are replayed: 1280 x 1024, upright or on their side.
#pragma once

namespace pirvs {

inline constexpr int kImagePixelsMax = 1280 * 1024;
inline constexpr int kImageSideMax = 1280;
inline constexpr int kPoolBytesMax = 96 << 20;

}  // namespace pirvs
