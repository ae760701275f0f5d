// What    What a recording of a board has shown, and what it lacks for a lens to be found.
// In      Shots with the board's pose: a rig that is roughly right will do.
// Out     measure: how the board stood, where its tags were. missing: the first lack by name and
//         what to do, empty if there is none. picture: tags in each cell of the image, a character
//         a cell: '.' none, '1'..'9' up to nine, '#' more.
// Units   degrees.
// Errors  none.
// Cost    ~1 us a tag.
#pragma once

#include <string>
#include <vector>

#include "tools/calib/camera_adjustment.h"

namespace pirvs::tools {

struct Coverage {
  static constexpr int kColumns = 16, kRows = 10;
  int cells[2][kRows][kColumns] = {};
  // Between the 5th and the 95th of a hundred shots; tilt: the 90th, of the board's normal against
  // the line of sight.
  double tilt_deg = 0, roll_deg = 0;
  double near_to_far = 1;
};

Coverage measure(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& shots);

struct Lack {
  std::string what, remedy;
};
Lack missing(const Coverage& coverage, int cameras);
std::string picture(const Coverage& coverage, int camera);

}  // namespace pirvs::tools
