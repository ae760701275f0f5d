// What    Images of a board, for tests: drawn through a lens, blurred, darkened, with noise.
// In      Camera, board, its pose.
// Out     8-bit grey, a mean of 9 samples a pixel.
// Frames  T_CT: from the board to the camera.
// Units   px, m, grey.
// Errors  none: what the lens does not see is grey.
// Cost    ~0.3 s for 640 x 480.
#pragma once

#include <opencv2/imgproc.hpp>

#include "core/camera/camera.h"
#include "tools/calib/board_drawing.h"
#include "tools/sim/random.h"

namespace pirvs::tools {

struct TestLight {
  double white = 200, black = 30;
  double blur_px = 0.5;
  double noise = 1;
};

class TestBoard {
 public:
  explicit TestBoard(const Target& target) : target_(target), margin_m_(target.tag_m) {
    const int width = int((target.columns * target.pitch_m() + 2 * margin_m_) / kPixel_m);
    const int height = int((target.rows * target.pitch_m() + 2 * margin_m_) / kPixel_m);
    face_ = cv::Mat(height, width, CV_8U, cv::Scalar(255));
    for (const Square& s : black_squares(target)) {
      const int x = at(s.x_m), y = at(s.y_m), x1 = at(s.x_m + s.side_m), y1 = at(s.y_m + s.side_m);
      face_(cv::Rect(x, y, x1 - x, y1 - y)) = s.black ? 0 : 255;
    }
  }

  cv::Mat draw(const Camera& camera, const SE3& T_CT, const TestLight& light, uint64_t seed) const {
    cv::Mat out(camera.height, camera.width, CV_32F, cv::Scalar(100));
    const SE3 T_TC = T_CT.inverse();
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        double sum = 0;
        for (int k = 0; k < 9; ++k) {
          sum += sample(camera, T_TC, Vec2(u + (k % 3 - 1) / 3.0, v + (k / 3 - 1) / 3.0), light);
        }
        out.at<float>(v, u) = float(sum / 9);
      }
    }
    if (light.blur_px > 0) cv::GaussianBlur(out, out, {0, 0}, light.blur_px);
    Random random(seed, 1);
    cv::Mat grey(out.size(), CV_8U);
    for (int v = 0; v < out.rows; ++v) {
      for (int u = 0; u < out.cols; ++u) {
        const double noisy = double(out.at<float>(v, u)) + light.noise * random.normal();
        grey.at<uint8_t>(v, u) = cv::saturate_cast<uint8_t>(noisy);
      }
    }
    return grey;
  }

 private:
  static constexpr double kPixel_m = 0.0004;

  int at(double m) const { return int((m + margin_m_) / kPixel_m + 0.5); }

  double sample(const Camera& camera, const SE3& T_TC, const Vec2& uv,
                const TestLight& light) const {
    Vec3 ray_C;
    const double wall = (light.white + light.black) / 2;
    if (!camera.unproject(uv, ray_C)) return wall;
    const Vec3 ray_T = T_TC.R * ray_C;
    const double way = -T_TC.p.z() / ray_T.z();
    if (!(way > 0)) return wall;
    const Vec3 p_T = T_TC.p + way * ray_T;
    const double x = (p_T.x() + margin_m_) / kPixel_m, y = (p_T.y() + margin_m_) / kPixel_m;
    if (!(x >= 0 && y >= 0 && x < face_.cols && y < face_.rows)) return wall;
    return face_.at<uint8_t>(int(y), int(x)) != 0 ? light.white : light.black;
  }

  Target target_;
  double margin_m_;
  cv::Mat face_;
};

}  // namespace pirvs::tools
