// The whole front-end of one camera on consecutive frames, against the same work by OpenCV:
// equalize, pyramid, flow forward (4 levels) and back (finest), drop, detect what is missing,
// describe it. Goal: ours takes at most half.
//
// The same work: as many tracks wanted after each frame as ours then had; flow windows of the same
// 16 x 16 px, the same iterations; corners over 5 x 5 px, the same least distance. OpenCV's ORB
// stands for the descriptor: one level, orientation given, 256 bits. The second row lets OpenCV
// detect by FAST, its cheapest corner, strongest first, where ours keeps to Shi-Tomasi.
#include "modules/frontend/frontend.h"

#include <cstdio>
#include <opencv2/features2d.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/kernels/kernel_bench.h"
#include "core/kernels/lk/lk.h"

namespace pirvs {
namespace {

constexpr int kFrames = 40;
constexpr TimeNs kPeriod_ns = 50'000'000;

Camera euroc_left() {
  Camera camera;
  camera.model = CameraModel::kPinholeRadtan;
  camera.width = 752;
  camera.height = 480;
  camera.fx = 458.654;
  camera.fy = 457.296;
  camera.cx = 367.215;
  camera.cy = 248.375;
  const double d[4] = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  std::copy(d, d + 4, camera.d);
  return camera;
}

// ours: the front-end as it stands, the camera taken to turn as little as it does in 50 ms.
void run_ours(Frontend& frontend, const std::vector<cv::Mat>& images, std::vector<int>* tracks) {
  frontend.reset();
  for (int i = 0; i < kFrames; ++i) {
    frontend.predict(Mat3::Identity());
    const Status status = frontend.process(bench::view(images[i]), i * kPeriod_ns, Vec3(0, 1, 0));
    PIRVS_ASSERT(status == Status::kOk);
    if (tracks != nullptr) tracks->push_back(static_cast<int>(frontend.tracks().size()));
  }
}

class OpenCvFrontend {
 public:
  enum class Corners { kShiTomasi, kFast };
  OpenCvFrontend(const FrontendParams& params, Corners corners)
      : params_(params), corners_kind_(corners) {}

  void reset() { points_.clear(); }
  size_t tracks() const { return points_.size(); }

  void process(const cv::Mat& image, int wanted) {
    cv::equalizeHist(image, equalized_);
    std::swap(from_, to_);
    cv::buildOpticalFlowPyramid(equalized_, to_, window_, static_cast<int>(params_.lk_levels) - 1);
    if (!points_.empty()) follow();
    detect(wanted);
  }

 private:
  void follow() {
    const auto stop = [&](int iterations) {
      return cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, iterations,
                              params_.lk_step_px_min);
    };
    cv::calcOpticalFlowPyrLK(from_, to_, points_, found_, ok_, residual_, window_,
                             static_cast<int>(params_.lk_levels) - 1,
                             stop(static_cast<int>(params_.lk_iterations_max)));
    back_ = points_;
    cv::calcOpticalFlowPyrLK(to_, from_, found_, back_, back_ok_, cv::noArray(), window_, 0,
                             stop(3), cv::OPTFLOW_USE_INITIAL_FLOW);
    size_t kept = 0;
    const cv::Rect2f inside(10, 10, static_cast<float>(equalized_.cols - 20),
                            static_cast<float>(equalized_.rows - 20));
    for (size_t i = 0; i < points_.size(); ++i) {
      if (!ok_[i] || !back_ok_[i] || !inside.contains(found_[i])) continue;
      if (residual_[i] > params_.lk_residual_grey_max) continue;
      if (cv::norm(back_[i] - points_[i]) > params_.lk_return_px_max) continue;
      points_[kept++] = found_[i];
    }
    points_.resize(kept);
  }

  void detect(int wanted) {
    const int missing = wanted - static_cast<int>(points_.size());
    if (missing <= 0) return;
    const int spacing = static_cast<int>(params_.track_spacing_px_min);
    mask_.create(equalized_.size(), CV_8U);
    mask_.setTo(0);
    mask_(cv::Rect(20, 20, mask_.cols - 40, mask_.rows - 40)).setTo(255);
    for (const cv::Point2f& p : points_) cv::circle(mask_, p, spacing, 0, cv::FILLED);
    if (corners_kind_ == Corners::kShiTomasi) {
      cv::goodFeaturesToTrack(equalized_, corners_, missing, 1e-3, spacing, mask_, 5);
    } else {
      detect_fast(static_cast<size_t>(missing), spacing);
    }
    cv::KeyPoint::convert(corners_, keypoints_, 31, 1, 0);
    for (cv::KeyPoint& keypoint : keypoints_) keypoint.angle = 0;
    if (!keypoints_.empty()) orb_->compute(equalized_, keypoints_, descriptors_);
    points_.insert(points_.end(), corners_.begin(), corners_.end());
  }

  void detect_fast(size_t missing, int spacing) {
    cv::FAST(equalized_, keypoints_, 20);
    std::sort(keypoints_.begin(), keypoints_.end(),
              [](const auto& a, const auto& b) { return a.response > b.response; });
    corners_.clear();
    for (const cv::KeyPoint& keypoint : keypoints_) {
      if (corners_.size() == missing) break;
      if (mask_.at<uint8_t>(cv::Point(keypoint.pt)) == 0) continue;
      cv::circle(mask_, keypoint.pt, spacing, 0, cv::FILLED);
      corners_.push_back(keypoint.pt);
    }
  }

  FrontendParams params_;
  Corners corners_kind_;
  cv::Size window_{kLkSize, kLkSize};
  cv::Ptr<cv::ORB> orb_ = cv::ORB::create(500, 1.2f, 1, 16);
  cv::Mat equalized_, mask_, descriptors_;
  std::vector<cv::Mat> from_, to_;
  std::vector<cv::Point2f> points_, found_, back_, corners_;
  std::vector<cv::KeyPoint> keypoints_;
  std::vector<uint8_t> ok_, back_ok_;
  std::vector<float> residual_;
};

Frontend frontend;

void whole_frontend(benchmark::State& state, OpenCvFrontend::Corners corners) {
  cv::setNumThreads(1);
  std::vector<cv::Mat> images;
  for (int i = 0; i < kFrames; ++i) images.push_back(bench::image(i));
  const FrontendParams params;
  frontend.configure(euroc_left(), params);
  std::vector<int> wanted;
  run_ours(frontend, images, &wanted);
  double ours_tracks = 0, opencv_tracks = 0;
  for (const int tracks : wanted) ours_tracks += tracks;

  OpenCvFrontend opencv(params, corners);
  const auto run_opencv = [&] {
    opencv.reset();
    opencv_tracks = 0;
    for (int i = 0; i < kFrames; ++i) {
      opencv.process(images[i], wanted[i]);
      opencv_tracks += static_cast<double>(opencv.tracks());
    }
  };
  bench::compare(state, {kFrames, [&] { run_ours(frontend, images, nullptr); }, {}, run_opencv});
  char label[160];
  std::snprintf(label, sizeof label,
                "ours %.2f ms, %.0f tracks; OpenCV %.2f ms, %.0f tracks; ours/OpenCV %.2f",
                state.counters["ours_ns"] * 1e-6, ours_tracks / kFrames,
                state.counters["opencv_ns"] * 1e-6, opencv_tracks / kFrames,
                static_cast<double>(state.counters["ours/opencv"]));
  state.SetLabel(label);
}
void few_rounds(benchmark::internal::Benchmark* row) {
  row->UseManualTime()->Iterations(15)->Unit(benchmark::kMillisecond);
}
BENCHMARK_CAPTURE(whole_frontend, shi_tomasi, OpenCvFrontend::Corners::kShiTomasi)
    ->Name("frontend_752x480")
    ->Apply(few_rounds);
BENCHMARK_CAPTURE(whole_frontend, fast, OpenCvFrontend::Corners::kFast)
    ->Name("frontend_752x480_opencv_fast")
    ->Apply(few_rounds);

}  // namespace
}  // namespace pirvs
