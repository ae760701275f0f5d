// What    Whether the left and the right image show what the calibration says of the pair.
// In      A recording with two cameras; up to 12 of its frames.
// Out     How far matches are off the epipolar curve, in the median, and how many of those near it
//         lie in front of both cameras.
// Units   pixels of the left image.
// Errors  enough: false where too few matches were found.
// Cost    ~40 ms a frame (x86-64).
// Source  ORB (Rublee et al., ICCV 2011) as OpenCV has it; the essential matrix of the calibration.
#pragma once

#include <string>
#include <vector>

#include "tools/dataset/recording.h"

namespace pirvs::tools {

struct StereoSense {
  bool enough = false;
  size_t matches = 0;
  double epipolar_px = 0;
  double in_front = 1;  // share of the matches near the curve, those at infinity left out
};

StereoSense compare_cameras(const Recording& recording);
std::vector<std::string> faults_of(const StereoSense& sense);

}  // namespace pirvs::tools
