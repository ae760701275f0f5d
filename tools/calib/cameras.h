// What    Calibrates one or two cameras from views of a board, from nothing but the size of images.
// In      Shots; the model, or both to try.
// Out     The rig with its covariance; what else a report shows; how well it does on shots that it
//         was not made from: `within` a camera, the board's pose from that camera's own corners;
//         `across`, the pose from the left camera's and the error in the right one.
// Frames  as in camera_adjustment.h.
// Errors  InputError: too few views, no focal length that explains them, or what is missing of the
//         views (coverage.h).
// Cost    april_euroc, 1439 pairs: 6 s of one core radtan, as much again equidistant.
// Source  starts from a ladder of focal lengths, so that no lens needs a guess.
#pragma once

#include <optional>
#include <vector>

#include "tools/calib/coverage.h"

namespace pirvs::tools {

struct CameraOptions {
  std::optional<CameraModel> model;  // none: the better one
  ImageSize size;
};

struct HeldOut {
  double within_px[2] = {0, 0};
  double across_px = 0;
  size_t shots = 0;
};

struct CameraResult {
  Target target;  // with the shape that its views have shown
  CameraRig rig;
  Adjustment adjustment;
  HeldOut held_out;
  Coverage coverage;
  std::vector<PosedShot> used;
  std::vector<PosedShot> all;  // every shot whose pose was found
  double other_model_px = 0;   // held out, of the model that was not taken; 0: not tried
};

CameraResult calibrate_cameras(const Target& target, const std::vector<Shot>& shots, int cameras,
                               const CameraOptions& options);

// The board in C0 for each shot where it can be found.
std::vector<PosedShot> pose_shots(const Target& target, const CameraRig& rig,
                                  const std::vector<Shot>& shots);

}  // namespace pirvs::tools
