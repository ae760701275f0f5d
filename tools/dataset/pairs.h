// What    Which images of two cameras were exposed together.
// In      Both cameras' images in order of time; how much later the right camera's stamps are.
// Out     Frames in order of time, with both images or one. A pair are two that are nearest to each
//         other and no farther apart than a quarter of the frame interval.
// Units   ns; a frame's t is the left image's stamp, or where there is none, the right one's less
//         `right_later`.
// Errors  none: images alone are counted, frames_without_left, frames_without_right; a constant
//         distance, and that nothing pairs, are noted.
// Cost    linear.
#pragma once

#include <vector>

#include "tools/dataset/sensor_tables.h"

namespace pirvs::tools {

struct PairedImages {
  TimeNs t = 0;
  std::string file[2];  // empty: no image
};

std::vector<PairedImages> pair_images(const std::vector<ListedImage>& left,
                                      const std::vector<ListedImage>& right, TimeNs right_later,
                                      InputLog& log);

// The middle of the steps between stamps; 0: fewer than two.
template <class Row>
TimeNs interval(const std::vector<Row>& rows);

// Says where rows are missing.
template <class Row>
void note_gaps(const std::vector<Row>& rows, const std::string& what, TimeNs least, InputLog& log);

}  // namespace pirvs::tools
