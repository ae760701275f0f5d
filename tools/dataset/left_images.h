// A recording of the left camera's images alone, for who plays some of them: no frames yet.
// In      the recording, whose images the result reads.
// Errors  none.
#pragma once

#include "tools/dataset/recording.h"

namespace pirvs::tools {

inline Recording left_images(const Recording& recording) {
  Recording out;
  out.folder = recording.folder;
  out.calibration = recording.calibration;
  out.calibration.cameras = 1;
  out.turns[0] = recording.turns[0];
  out.pack = recording.pack;
  out.store = recording.store;
  return out;
}

}  // namespace pirvs::tools
