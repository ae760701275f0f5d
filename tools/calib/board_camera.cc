#include "tools/calib/board_camera.h"

#include <opencv2/imgproc.hpp>

#include "tools/calib/board_drawing.h"
#include "tools/sim/random.h"

namespace pirvs::tools {

BoardCamera::BoardCamera(const Target& target, const Camera& camera)
    : camera_(camera), margin_m_(target.tag_m) {
  const auto at = [this](double m) { return int((m + margin_m_) / kPixel_m + 0.5); };
  face_ = cv::Mat(at(target.rows * target.pitch_m() + margin_m_),
                  at(target.columns * target.pitch_m() + margin_m_), CV_8U, cv::Scalar(255));
  for (const Square& s : black_squares(target)) {
    const int x = at(s.x_m), y = at(s.y_m), x1 = at(s.x_m + s.side_m), y1 = at(s.y_m + s.side_m);
    face_(cv::Rect(x, y, x1 - x, y1 - y)) = s.black ? 0 : 255;
  }
  rays_C_.reserve(size_t(camera.width) * size_t(camera.height) * kSamples);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      for (int k = 0; k < kSamples; ++k) {
        const Vec2 aside(k % kSide - 1, k / kSide - 1);
        Vec3 ray_C;
        const bool seen = camera.unproject(Vec2(u, v) + aside / kSide, ray_C);
        rays_C_.push_back(seen ? ray_C.cast<float>() : Eigen::Vector3f(0, 0, 0));
      }
    }
  }
}

bool BoardCamera::white(const SE3& T_TC, const Vec3& ray_C, bool& seen) const {
  seen = false;
  const Vec3 ray_T = T_TC.R * ray_C;
  const double way = -T_TC.p.z() / ray_T.z();
  if (!(way > 0)) return false;
  const double x = (T_TC.p.x() + way * ray_T.x() + margin_m_) / kPixel_m;
  const double y = (T_TC.p.y() + way * ray_T.y() + margin_m_) / kPixel_m;
  if (!(x >= 0 && y >= 0 && x < face_.cols && y < face_.rows)) return false;
  seen = true;
  return face_.at<uint8_t>(int(y), int(x)) != 0;
}

cv::Mat BoardCamera::draw(const std::vector<SE3>& T_CT, const BoardLight& light,
                          uint64_t seed) const {
  // Samples of a pixel are shared out over the exposure as well: those of a row of the image
  // differ, so that no edge is seen at one time alone.
  SE3 T_TC[kSamples];
  for (size_t k = 0; k < kSamples; ++k) T_TC[k] = T_CT[k * T_CT.size() / kSamples].inverse();
  cv::Mat out(camera_.height, camera_.width, CV_32F);
  const float wall = float(light.white + light.black) / 2;
  size_t at = 0;
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      float sum = 0;
      for (int k = 0; k < kSamples; ++k, ++at) {
        bool seen = false;
        const bool is_white =
            white(T_TC[(k * 4 + u + 2 * v) % kSamples], rays_C_[at].cast<double>(), seen);
        sum += !seen ? wall : float(is_white ? light.white : light.black);
      }
      out.at<float>(v, u) = sum / kSamples;
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

}  // namespace pirvs::tools
