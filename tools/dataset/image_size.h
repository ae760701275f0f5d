// What    The size of a recording's images, for a calibration that has lenses of several sizes.
// In      Folders, in the order in which they are looked into.
// Out     Width and height of the first image by name that can be decoded; zeros: there is none.
// Units   pixels.
// Errors  none.
// Cost    one image decoded.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace pirvs::tools {

std::pair<int, int> image_size_in(const std::vector<std::string>& folders);

}  // namespace pirvs::tools
