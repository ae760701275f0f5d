// Parameters in pixels are tuned on EuRoC's lens. Those that mean an angle are scaled to another
// one, so that a default means the same on every lens; those that mean how well a place is found
// in an image stay: flow errs by a share of a pixel, whatever a pixel sees (docs/conventions.md).
// In      parameters as set, the left camera. Out: parameters as used; unchanged, to the bit, for
//         the focal length they were tuned on.
// Errors  none; a bin keeps within the limits of its row.
#pragma once

#include <algorithm>

#include "core/camera/camera.h"
#include "modules/app/app_params.h"

namespace pirvs {

inline constexpr double kTunedFocal_px = 458.654;  // fx of EuRoC's left camera

inline AppParams for_lens(AppParams params, const Camera& left) {
  const float scale = static_cast<float>(left.fx / kTunedFocal_px);
  FrontendParams& frontend = params.frontend;
  frontend.bin_px = std::clamp(frontend.bin_px * scale, static_cast<float>(kBinMin_px),
                               static_cast<float>(kBinMax_px));
  frontend.track_spacing_px_min *= scale;
  MatchingParams& matching = params.tracking.matching;
  matching.match_radius_px_max =
      std::max(matching.match_radius_px_min, matching.match_radius_px_max * scale);
  return params;
}

}  // namespace pirvs
