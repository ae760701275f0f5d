#include "tools/info/stereo_sense.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/features2d.hpp>

#include "tools/dataset/player.h"

namespace pirvs::tools {
namespace {

struct Features {
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
};

Features features_of(const ImageView& image) {
  constexpr int kFeatures = 600;
  cv::Mat grey(image.height, image.width, CV_8UC1);
  for (int y = 0; y < image.height; ++y) std::copy_n(image.row(y), image.width, grey.ptr(y));
  Features out;
  cv::ORB::create(kFeatures)->detectAndCompute(grey, cv::noArray(), out.points, out.descriptors);
  return out;
}

// Depths along two rays of one frame; false: they are parallel.
bool depths(const Vec3& a, const Vec3& b, const Vec3& t, double& along_a, double& along_b) {
  constexpr double kParallel = 3e-5;  // 0.3 degrees
  const double ab = a.dot(b), det = 1 - ab * ab;
  if (det < kParallel) return false;
  along_a = (a.dot(t) - ab * b.dot(t)) / det;
  along_b = (ab * a.dot(t) - b.dot(t)) / det;
  return true;
}

struct Sums {
  std::vector<double> epipolar_px;
  size_t front = 0, behind = 0;
};

void compare(const Recording& recording, const StereoFrame& frame, Sums& sums) {
  constexpr double kNear_px = 2;
  const Camera& left = recording.calibration.camera[0];
  const Camera& right = recording.calibration.camera[1];
  const SE3 T_C0C1 = left.T_BC.inverse() * right.T_BC;
  const Features a = features_of(frame.image[0]), b = features_of(frame.image[1]);
  if (a.points.empty() || b.points.empty()) return;
  std::vector<cv::DMatch> matches;
  cv::BFMatcher(cv::NORM_HAMMING, true).match(a.descriptors, b.descriptors, matches);
  constexpr float kDistance_max = 40;
  for (const cv::DMatch& match : matches) {
    if (match.distance > kDistance_max) continue;
    const cv::Point2f p = a.points[size_t(match.queryIdx)].pt;
    const cv::Point2f q = b.points[size_t(match.trainIdx)].pt;
    Vec3 ray_0, ray_1;
    if (!left.unproject(Vec2(p.x, p.y), ray_0) || !right.unproject(Vec2(q.x, q.y), ray_1)) continue;
    const Vec3 in_0 = T_C0C1.R * ray_1;
    const Vec3 normal = T_C0C1.p.cross(in_0);
    if (normal.norm() < 1e-6) continue;
    const double off_px = std::abs(std::asin(ray_0.dot(normal.normalized()))) * left.fx;
    sums.epipolar_px.push_back(off_px);
    double along_0 = 0, along_1 = 0;
    if (off_px > kNear_px || !depths(ray_0, in_0, T_C0C1.p, along_0, along_1)) continue;
    ++(along_0 > 0 && along_1 > 0 ? sums.front : sums.behind);
  }
}

}  // namespace

StereoSense compare_cameras(const Recording& recording) {
  constexpr size_t kFrames = 12, kMatchesMin = 60;
  StereoSense out;
  if (recording.calibration.cameras < 2) return out;
  Recording part = recording;
  part.order.clear();
  part.frames.clear();
  std::vector<const FrameFiles*> pairs;
  for (const FrameFiles& frame : recording.frames) {
    const auto has = [&](int c) {
      return !frame.image[c].empty() || frame.pixels[c].data != nullptr;
    };
    if (has(0) && has(1)) pairs.push_back(&frame);
  }
  const size_t stride = std::max<size_t>(1, pairs.size() / kFrames);
  for (size_t i = 0; i < pairs.size(); i += stride) part.frames.push_back(*pairs[i]);
  if (part.frames.empty()) return out;
  Sums sums;
  Player player(part);
  while (const StereoFrame* const frame = player.next()) {
    if (frame->present == 3) compare(recording, *frame, sums);
    player.release(frame);
  }
  out.matches = sums.epipolar_px.size();
  if (out.matches < kMatchesMin) return out;
  const auto middle = sums.epipolar_px.begin() + std::ptrdiff_t(sums.epipolar_px.size() / 2);
  std::nth_element(sums.epipolar_px.begin(), middle, sums.epipolar_px.end());
  out.enough = true;
  out.epipolar_px = *middle;
  const size_t judged = sums.front + sums.behind;
  if (judged >= kMatchesMin / 2) out.in_front = double(sums.front) / double(judged);
  return out;
}

std::vector<std::string> faults_of(const StereoSense& sense) {
  constexpr double kEpipolar_px_max = 4, kFront_min = 0.5;
  std::vector<std::string> out;
  if (!sense.enough) return out;
  if (sense.epipolar_px > kEpipolar_px_max) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "left and right images do not fit the calibration, matches are %.1f px off the "
                  "epipolar curve: check T_BS of both, and that pairs are pairs",
                  sense.epipolar_px);
    out.push_back(text);
  } else if (sense.in_front < kFront_min) {
    out.push_back(
        "points lie behind the cameras: left and right images are exchanged, or the "
        "baseline's sign is");
  }
  return out;
}

}  // namespace pirvs::tools
