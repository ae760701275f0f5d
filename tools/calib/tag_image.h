// What    Where a camera sees a tag: the mean of the images of its four corners.
// In      Camera, board, the board's pose, a tag.
// Out     uv and its derivatives.
// Frames  T_CT: from the board to the camera; theta of R_CT Exp(theta).
// Units   px, m, rad.
// Errors  false: the lens cannot see one of its corners.
// Cost    ~0.5 us.
// Source  A corner alone is seen too far inside its tag, by 0.1 to 1 px, as overexposure, blur and
//         the detector have it, and differently all over the image. That moves the corners of a tag
//         towards each other and leaves their mean where it is: EuRoC's corners scatter by 0.15
//         px, the means of four by 0.06.
#pragma once

#include "tools/calib/lens.h"
#include "tools/calib/target.h"

namespace pirvs::tools {

struct TagImage {
  Vec2 uv;
  Eigen::Matrix<double, 2, 6> by_pose;  // theta, p_CT
  Mat28 by_lens;
  Mat23 by_shift;  // of the tag, in T
};

bool project_tag(const Camera& camera, const Target& target, const SE3& T_CT, int tag,
                 TagImage& out);

// The same where T_CT = T_C1C0 T_C0T.
struct StereoParts {
  Mat23 by_p_C0T, by_theta_C1C0;  // by_pose has the rest: theta_C0T, p_C1C0
};
StereoParts stereo_parts(const TagImage& image, const Mat3& R_C1C0, const SE3& T_C0T);

}  // namespace pirvs::tools
