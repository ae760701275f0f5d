// What    `pirvs info` as a page: what it says, with plots.
// In      A recording, and what was found in it.
// Out     HTML that needs nothing but itself: force and rate over time, the steps of the stamps,
//         the lenses' distortion over the image, how far images and gyro agree at each time offset,
//         the truth from above.
// Units   as labelled; times in seconds since the first frame.
// Errors  none.
#pragma once

#include <string>
#include <vector>

#include "tools/dataset/recording.h"
#include "tools/info/image_turn.h"

namespace pirvs::tools {

struct InfoFindings {
  std::string text;                 // one line each
  std::vector<std::string> faults;  // what is wrong, and what to do
  ImageTurn turn;
};

std::string info_report(const Recording& recording, const InfoFindings& found);

}  // namespace pirvs::tools
