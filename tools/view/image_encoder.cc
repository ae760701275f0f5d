#include "tools/view/image_encoder.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "bsp/api/clock.h"
#include "modules/tracking/tracker.h"

namespace pirvs::tools {

std::string view_jpeg(const cv::Mat& image) {
  constexpr int kQuality = 75;
  cv::Mat small = image;
  if (image.cols > ImageEncoder::kWidthMax) {
    const double scale = double(ImageEncoder::kWidthMax) / image.cols;
    cv::resize(image, small, cv::Size(), scale, scale, cv::INTER_AREA);
  }
  std::vector<uint8_t> out;
  cv::imencode(".jpg", small, out, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return {reinterpret_cast<const char*>(out.data()), out.size()};
}

ImageEncoder::ImageEncoder(Scene& scene) : scene_(scene), thread_([this] { run(); }) {}

ImageEncoder::~ImageEncoder() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void ImageEncoder::offer(TimeNs t, const StereoFrame& frame, const Tracker& tracker) {
  if (busy_.load(std::memory_order_acquire) || bsp::now() < next_t_) return;
  next_t_ = bsp::now() + kPeriod_ns;
  for (int c = 0; c < kCamerasMax; ++c) {
    const ImageView& image = frame.image[c];
    images_[c] = {};
    if ((frame.present >> c & 1) == 0 || image.data == nullptr) continue;
    const cv::Mat lent(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                       size_t(image.stride));
    lent.copyTo(pixels_[c]);
    images_[c] = {t, c, image.width, image.height, {}, {}};
    for (const Track& track : tracker.tracks(c)) {
      images_[c].tracks.push_back({track.x, track.y, static_cast<float>(track.age),
                                   static_cast<float>(tracker.use(c, track))});
    }
  }
  {
    const std::lock_guard lock(mutex_);
    busy_ = true;
  }
  wake_.notify_one();
}

void ImageEncoder::run() {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || busy_; });
      if (stop_) return;
    }
    for (int c = 0; c < kCamerasMax; ++c) {
      if (images_[c].width == 0) continue;
      images_[c].jpeg = view_jpeg(pixels_[c]);
      scene_.image(std::move(images_[c]));
    }
    busy_.store(false, std::memory_order_release);
  }
}

}  // namespace pirvs::tools
