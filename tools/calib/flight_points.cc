#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "tools/calib/flight_check.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/player.h"

namespace pirvs::tools {
namespace {

constexpr int kPoints = 150;
constexpr size_t kPointsMin = 12;
constexpr TimeNs kLook_ns = 150'000'000;
constexpr size_t kLooksMax = 400;

using Points = std::vector<cv::Point2f>;

cv::Mat image_of(const StereoFrame& frame, int camera) {
  const ImageView& view = frame.image[camera];
  const cv::Mat lent(view.height, view.width, CV_8U, const_cast<uint8_t*>(view.data),
                     size_t(view.stride));
  return lent.clone();
}

// There and back again.
void track(const cv::Mat& from, const cv::Mat& to, const Points& at, Points& out,
           std::vector<uint8_t>& good) {
  constexpr double kBack_px = 0.3;
  const cv::TermCriteria until(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 30, 0.005);
  const cv::Size window(21, 21);
  constexpr int kLevels = 4;
  std::vector<uint8_t> forth, back;
  std::vector<float> error;
  Points again = at;
  out = at;
  cv::calcOpticalFlowPyrLK(from, to, at, out, forth, error, window, kLevels, until);
  cv::calcOpticalFlowPyrLK(to, from, out, again, back, error, window, kLevels, until);
  good.assign(at.size(), 0);
  for (size_t i = 0; i < at.size(); ++i) {
    good[i] = forth[i] != 0 && back[i] != 0 && cv::norm(again[i] - at[i]) < kBack_px;
  }
}

FlightLook look(TimeNs t0, const cv::Mat& left, const cv::Mat& right, TimeNs t1,
                const cv::Mat& later) {
  FlightLook out;
  out.t0 = t0, out.t1 = t1;
  Points at, at_right, at_later;
  cv::goodFeaturesToTrack(left, at, kPoints, 0.01, 15);
  if (at.size() < kPointsMin) return out;
  std::vector<uint8_t> good_right, good_later;
  track(left, right, at, at_right, good_right);
  track(left, later, at, at_later, good_later);
  const auto vec = [](const cv::Point2f& p) { return Vec2(double(p.x), double(p.y)); };
  for (size_t i = 0; i < at.size(); ++i) {
    if (good_right[i] == 0 || good_later[i] == 0) continue;
    out.points.push_back({vec(at[i]), vec(at_right[i]), vec(at_later[i])});
  }
  return out;
}

}  // namespace

std::vector<FlightLook> follow(const Recording& recording) {
  if (recording.calibration.cameras < 2) {
    throw InputError("one camera alone", recording.folder, "give a recording of both");
  }
  std::vector<FlightLook> out;
  Player player(recording);
  cv::Mat left, right;
  TimeNs begin = 0;
  const TimeNs all = recording.frames.back().t - recording.frames.front().t;
  const TimeNs pause = std::max<TimeNs>(0, all / TimeNs(kLooksMax) - kLook_ns);
  TimeNs not_before = INT64_MIN;
  while (const StereoFrame* frame = player.next()) {
    const bool both = frame->present == 3;
    if (both && !left.empty() && frame->t - begin >= kLook_ns) {
      FlightLook found = look(begin, left, right, frame->t, image_of(*frame, 0));
      if (found.points.size() >= kPointsMin) out.push_back(std::move(found));
      left.release();
      not_before = frame->t + pause;
    }
    if (both && left.empty() && frame->t >= not_before) {
      left = image_of(*frame, 0);
      right = image_of(*frame, 1);
      begin = frame->t;
    }
    player.release(frame);
  }
  return out;
}

}  // namespace pirvs::tools
