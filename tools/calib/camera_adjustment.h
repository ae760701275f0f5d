// What    Bundle adjustment of one or two cameras over views of a board: intrinsics, the right
//         camera against the left, the board's pose in each shot; the board's own shape, too: paper
//         on wood is bent and stretched by half a millimetre, which moves a principal point by
//         pixels.
// In      A rig close enough to converge; shots with the board's pose in C0.
// Out     The same, adjusted; noise of a tag, residuals, the covariance of the rig's unknowns.
// Frames  T_C1C0: from the left to the right camera. Rotations are perturbed as R Exp(theta).
// Units   px, m, rad. rig unknowns: 8 of camera 0 (lens.h); with two cameras 8 of camera 1, then
//         theta and p of T_C1C0: 22 in all.
// Errors  false: the solver failed or some unknown is not observed.
// Cost    ~15 ms an iteration per 1,000 tags, two threads; about 10 iterations.
// Source  Zhang, PAMI 2000; Strobl, Hirzinger, ICCV workshops 2011 (the board's shape); Cauchy
//         weights at three sigma, sigma from the residuals themselves.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/camera/camera.h"
#include "tools/calib/views.h"

namespace pirvs::tools {

struct CameraRig {
  Camera camera[2];
  int cameras = 1;
  SE3 T_C1C0;

  int unknowns() const { return cameras == 2 ? 22 : 8; }
};

struct PosedShot {
  Shot shot;
  SE3 T_C0T;
};

struct Adjustment {
  double sigma_px = 0;        // of a tag (tag_image.h), per axis: robust
  double rms_px[2] = {0, 0};  // of all inliers
  size_t tags[2] = {0, 0};
  size_t outliers = 0;
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd board_covariance;  // of the tags' shifts, three a tag, by id
};

// How far a tag may be off its place on a flat board, one sigma. Paper stretches, and is glued
// askew: EuRoC's board is 0.3 % longer one way than the other.
Vec3 tag_prior_m(const Target& target);

// bent: tags may be off their places on a flat board, and target.shift_T says how far. Only then
// are there covariances.
bool adjust(Target& target, bool bent, CameraRig& rig, std::vector<PosedShot>& shots,
            Adjustment& out);

}  // namespace pirvs::tools
