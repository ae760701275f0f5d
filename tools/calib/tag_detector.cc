#include "tools/calib/tag_detector.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

namespace pirvs::tools {
namespace {

constexpr double kRim_px = 3;  // a corner nearer to it has no whole window
constexpr double kMoved_part =
    0.1;  // of a tag's side: a corner that refining moves further is none
constexpr int kWindow_max = 7;
constexpr int kZoom = 2;
constexpr double kBorder = 0.2;  // of a tag's side: black on its inside, Kalibr's

struct Tag {
  cv::Point2f corner[4];
  double side_px = 0;
  bool twice = false;
};

Tag tag_of(const apriltag_detection_t& found) {
  Tag out;
  double around_px = 0;
  for (int k = 0; k < 4; ++k) {
    const int next = (k + 1) % 4;
    around_px += std::hypot(found.p[k][0] - found.p[next][0], found.p[k][1] - found.p[next][1]);
    // libapriltag has (0, 0) at the first pixel's corner.
    out.corner[k] = {float(found.p[k][0] / kZoom - 0.5), float(found.p[k][1] / kZoom - 0.5)};
  }
  out.side_px = around_px / 4 / kZoom;
  return out;
}

bool at_rim(const Tag& tag, const cv::Mat& image) {
  return std::any_of(tag.corner, tag.corner + 4, [&](const cv::Point2f& p) {
    return !(p.x >= kRim_px && p.y >= kRim_px && p.x <= image.cols - 1 - kRim_px &&
             p.y <= image.rows - 1 - kRim_px);
  });
}

// Kalibr's squares touch the tags' corners, and libapriltag takes what touches for one shape: white
// grows by half a pixel.
cv::Mat parted(const cv::Mat& image) {
  cv::Mat out;
  cv::resize(image, out, {}, kZoom, kZoom, cv::INTER_CUBIC);
  cv::dilate(out, out, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  return out;
}

// Refines the four corners to sub-pixel; false where one moves too far from where it was detected.
bool refine(const cv::Mat& image, Tag& tag) {
  std::vector<cv::Point2f> corners(tag.corner, tag.corner + 4);
  const int half = std::clamp(int(kBorder * tag.side_px * 0.75), 2, kWindow_max);
  const cv::TermCriteria until(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 30, 0.005);
  cv::cornerSubPix(image, corners, {half, half}, {-1, -1}, until);
  for (size_t k = 0; k < 4; ++k) {
    if (cv::norm(corners[k] - tag.corner[k]) > std::max(1.0, kMoved_part * tag.side_px)) {
      return false;
    }
    tag.corner[k] = corners[k];
  }
  return true;
}

}  // namespace

TagDetector::TagDetector(const Target& target)
    : target_(target),
      family_{make_family(1), make_family(2)},
      detector_(apriltag_detector_create()) {
  for (const Family& family : family_) {
    apriltag_detector_add_family_bits(detector_, family.get(), 1);
  }
  detector_->nthreads = 1;
  detector_->quad_decimate = kZoom;
}

TagDetector::~TagDetector() { apriltag_detector_destroy(detector_); }

std::vector<Corner> TagDetector::find(const cv::Mat& grey, Dropped& dropped) {
  const cv::Mat image = parted(grey);
  image_u8_t view = {image.cols, image.rows, int(image.step), image.data};
  zarray_t* const found = apriltag_detector_detect(detector_, &view);
  std::map<int, Tag> tags;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(found, i, static_cast<void*>(&detection));
    if (detection->id >= target_.tags()) {
      ++dropped.unknown;
      continue;
    }
    const Tag tag = tag_of(*detection);
    const auto [at, fresh] = tags.try_emplace(detection->id, tag);
    // The same quadrilateral may be read as either family.
    if (!fresh && cv::norm(at->second.corner[0] - tag.corner[0]) > tag.side_px / 2) {
      at->second.twice = true;
    }
  }
  apriltag_detections_destroy(found);
  std::vector<Corner> out;
  for (auto& [id, tag] : tags) {
    if (tag.twice) {
      ++dropped.doubled;
    } else if (at_rim(tag, grey)) {
      ++dropped.at_rim;
    } else if (!refine(grey, tag)) {
      ++dropped.unsettled;
    } else {
      for (int k = 0; k < 4; ++k) {
        out.push_back({4 * id + k, Vec2(double(tag.corner[k].x), double(tag.corner[k].y))});
      }
    }
  }
  return out;
}

}  // namespace pirvs::tools
