// What    How the left camera turns by its images, against how the gyro says that it turns.
// In      A recording; up to 120 pairs of frames of it, those that turn most.
// Out     How late the camera's stamps are against the calibration, how the camera stands to the
//         IMU, the turn of the images per turn of the gyro, and how far they agree at best.
// Frames  R_BC as found; as the recording's calibration has it, it is within off_deg.
// Units   s, degrees.
// Errors  enough: false where too few pairs could be measured, or they agree with nothing.
// Cost    ~20 ms a pair, 2 s in all (x86-64).
// Source  Rotation of two views by the essential matrix (Nister, PAMI 2004); of one rate against
//         the other by Kabsch, 1976.
#pragma once

#include <string>
#include <vector>

#include "tools/dataset/recording.h"

namespace pirvs::tools {

struct ImageTurn {
  bool enough = false;
  size_t pairs = 0;
  double agreement = 0;        // 1: all that the gyro measured is seen in the images; 0: nothing
  double as_given = 0;         // the same with the stamps as the calibration takes them
  double late_s = 0;           // stamps are later than the calibration says
  double off_deg = 0;          // between R_BC and the calibration's
  double inverse_off_deg = 0;  // and its inverse
  double gyro_scale = 1;       // gyro over images
  std::vector<double> lag_s, misfit;  // of each lag that was tried, relative
};

ImageTurn compare_turns(const Recording& recording);

// What it says is wrong, with what to do; empty: nothing.
std::vector<std::string> faults_of(const ImageTurn& turn);

}  // namespace pirvs::tools
