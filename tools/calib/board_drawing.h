// What    A board as it is printed: black squares on white, and a PDF of them.
// In      Target; the size of the paper.
// Out     black_squares: in the order in which they are to be painted, white bits last. write_pdf:
//         one page, a ruler of 100 mm and the board's sizes below it.
// Frames  T as target.h: x right, y up.
// Units   m; paper in mm.
// Errors  InputError: the board does not fit the paper, the file cannot be written.
// Source  Kalibr wiki, "Calibration targets": tags of 36h11 (libapriltag's) with a border of two
//         bits, squares at their corners, which make each corner a crossing of two edges.
#pragma once

#include <string>
#include <vector>

#include "tools/calib/target.h"

namespace pirvs::tools {

struct Square {
  double x_m = 0, y_m = 0, side_m = 0;  // its bottom left corner
  bool black = true;
};

std::vector<Square> black_squares(const Target& target);

struct Paper {
  double width_mm = 0, height_mm = 0;  // 0: as the board needs it
};

void write_pdf(const Target& target, const Paper& paper, const std::string& path);

}  // namespace pirvs::tools
