// A scene point as one camera sees it, from image to image.
// Frames  distorted pixels, (0,0) = centre of the first pixel.
#pragma once

#include <cstdint>

#include "core/kernels/describe/describe.h"
#include "core/store/fixed_vector.h"

namespace pirvs {

using TrackId = uint32_t;  // 0: none

struct Track {
  TrackId id = 0;
  uint16_t slot = 0;                 // below kTracksMax, its own while it lives: see track_table.h
  float x = 0, y = 0;                // where it is now
  float x_last = 0, y_last = 0;      // where it was in the previous image
  float x_pred = 0, y_pred = 0;      // where it is expected in the next image
  float x_turned = 0, y_turned = 0;  // where the camera's turn alone would have brought it
  float x_parallax = 0, y_parallax = 0;  // from there to where it was found
  uint16_t age = 0;                      // images since it was detected
  bool described = false;
  Descriptor descriptor{};
};

inline constexpr int kTracksMax = 256;
using Tracks = FixedVector<Track, kTracksMax>;

}  // namespace pirvs
