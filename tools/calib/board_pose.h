// What    Where the board stands in front of one camera, from one view of it.
// In      A calibrated camera, the board, a view.
// Out     T_CT and the residual. find_pose starts from nothing, refine_pose from a pose.
// Frames  C: camera; T: board.
// Units   m, px.
// Errors  false: fewer than 6 tags that the lens can see, tags on a line, no pose with the
//         board in front.
// Cost    ~0.2 ms for 36 tags.
// Source  plane to image, direct linear transformation (Hartley, Zisserman, section 4.1), on rays,
//         so that fields of view beyond 180 degrees do no harm; then Gauss-Newton with Huber
//         weights.
#pragma once

#include "core/camera/camera.h"
#include "tools/calib/views.h"

namespace pirvs::tools {

struct BoardPose {
  SE3 T_CT;
  double rms_px = 0;  // of all tags, the two axes apart
};

bool find_pose(const Camera& camera, const Target& target, const View& view, BoardPose& out);
bool refine_pose(const Camera& camera, const Target& target, const View& view, BoardPose& pose);

}  // namespace pirvs::tools
