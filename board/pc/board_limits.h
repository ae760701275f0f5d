// What the static memory of this board's build is laid out for; core/base/limits.h includes it.
// Source  The largest sensors that are replayed on a PC (board/host): 1280 x 1024.
#pragma once

namespace pirvs {

inline constexpr int kImagePixelsMax = 1280 * 1024;
inline constexpr int kImageSideMax = 1280;
inline constexpr int kPoolBytesMax = 96 << 20;

}  // namespace pirvs
