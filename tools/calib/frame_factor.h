// What    All that one image says, to first order: of where the board stands before the camera and
//         of the lens.
// In      The tags, a lens and a pose near the truth; noise of a tag.
// Out     residual = A (theta, dp, lens - lens0) + c, of sigma 1, with R_CT = R0 Exp(theta) and
//         p_CT = p0 + dp: the tags' own sum of squares but for a constant. Huber weights.
//         by_board: the same residual's derivative by each tag's shift.
// Errors  false: fewer than 6 tags that the lens can see.
// Cost    ~50 us for 36 tags, instead of that many in each iteration of an adjustment.
// Source  QR of the tags' Jacobian (Golub, Van Loan, section 5.2).
#pragma once

#include "tools/calib/lens.h"
#include "tools/calib/views.h"

namespace pirvs::tools {

inline constexpr int kFrameSize = 6 + kLensSize;

struct FrameFactor {
  SE3 T_CT;
  LensVector lens;
  Eigen::Matrix<double, kFrameSize, kFrameSize> A;
  Eigen::Matrix<double, kFrameSize, 1> c;
};

// Three columns a tag, of those that the image shows.
struct BoardRows {
  std::vector<int> tags;
  Eigen::Matrix<double, kFrameSize, Eigen::Dynamic> by_shift;
};

bool make_frame_factor(const Camera& camera, const Target& target, const View& view,
                       const SE3& T_CT, double sigma_px, FrameFactor& out, BoardRows& by_board);

}  // namespace pirvs::tools
