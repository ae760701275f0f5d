// What    Draws images of a board: through a lens, blurred by motion and focus, dark, with noise.
// In      Camera, board (flat); where the board stood while the shutter was open.
// Out     8-bit grey, a mean of 9 samples a pixel.
// Frames  T_CT: from the board to the camera.
// Units   px, m, grey.
// Errors  none: what the lens does not see is grey.
// Cost    640 x 480: ~0.7 s once, ~0.06 s an image. draw() may be called from several threads.
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/camera/camera.h"
#include "tools/calib/target.h"

namespace pirvs::tools {

struct BoardLight {
  double white = 200, black = 30;
  double blur_px = 0.5;  // of the lens, one sigma
  double noise = 1;
};

class BoardCamera {
 public:
  BoardCamera(const Target& target, const Camera& camera);

  // T_CT: evenly over the exposure; one, if nothing moves.
  cv::Mat draw(const std::vector<SE3>& T_CT, const BoardLight& light, uint64_t seed) const;

 private:
  static constexpr int kSide = 3, kSamples = kSide * kSide;
  static constexpr double kPixel_m = 0.0004;

  bool white(const SE3& T_TC, const Vec3& ray_C, bool& seen) const;

  Camera camera_;
  double margin_m_;
  cv::Mat face_;
  std::vector<Eigen::Vector3f> rays_C_;  // of each sample; zero where the lens sees nothing
};

}  // namespace pirvs::tools
