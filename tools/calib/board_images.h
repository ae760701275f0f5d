// What    The tags in the images of a recording: an ASL folder, which needs no calibration.
// In      Folder (or its mav0) with cam0, perhaps cam1: data.csv beside data/, or file names that
//         are stamps. At most so many images a second are looked at, evenly, and for so long.
// Out     Corners of each image in order of time, the size of images; what was dropped, by name.
// Units   as tag_detector.h.
// Errors  InputError: no images, images of several sizes, none of them shows the board.
// Cost    ~35 ms an image, one core a camera.
#pragma once

#include <string>
#include <vector>

#include "tools/calib/views.h"

namespace pirvs::tools {

struct ImageCorners {
  TimeNs t = 0;
  std::vector<Corner> corners;
};

struct BoardImages {
  int cameras = 1;
  ImageSize size;
  std::vector<ImageCorners> images[2];
  double rate_hz[2] = {0, 0};  // as recorded
  double mean_grey = 0;        // of all images
  double left_out_s = 0;       // at the end, beyond duration_s_max
};

BoardImages find_boards(const std::string& folder, const Target& target, double rate_hz_max,
                        double duration_s_max, InputLog& log);

// As `--corners` takes them.
void write_corners(const std::vector<ImageCorners>& images, const std::string& path);

// mav0 below a folder, or the folder itself.
std::string mav0_of(const std::string& folder);

}  // namespace pirvs::tools
