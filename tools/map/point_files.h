// What    Points of a map as other programs read them: x y z in W; sigma_m, the root of the
//         covariance's trace; views.
// Units   m.
// Source  PLY (Turk, 1994), ASCII; the Point Cloud Library's PCD, version 0.7, ASCII.
#pragma once

#include <string>
#include <vector>

#include "modules/map/map.h"

namespace pirvs::tools {

std::string points_ply(const std::vector<Landmark>& points);
std::string points_pcd(const std::vector<Landmark>& points);

}  // namespace pirvs::tools
