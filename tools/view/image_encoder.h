// What    JPEGs of a stereo frame with its tracks, made by a thread of its own.
// In      offer(): from the core that tracks; images are copied, if the last ones are done and
//         kPeriod_ns has passed.
// Out     Scene::image(), made smaller to at most kWidthMax pixels a row.
// Errors  none: what comes too soon is left out.
// Cost    offer ~80 us for two of 752 x 480, 12 times a second, else a load; the thread ~2 ms an
//         image.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <opencv2/core.hpp>
#include <thread>

#include "bsp/api/camera.h"
#include "tools/view/scene.h"

namespace pirvs {
class Tracker;
}

namespace pirvs::tools {

// Made smaller if it is wide.
std::string view_jpeg(const cv::Mat& image);

class ImageEncoder {
 public:
  static constexpr TimeNs kPeriod_ns = 80'000'000;
  static constexpr int kWidthMax = 400;

  explicit ImageEncoder(Scene& scene);
  ~ImageEncoder();
  ImageEncoder(const ImageEncoder&) = delete;
  ImageEncoder& operator=(const ImageEncoder&) = delete;

  void offer(TimeNs t, const StereoFrame& frame, const Tracker& tracker);

 private:
  void run();

  Scene& scene_;
  TimeNs next_t_ = 0;  // on this machine's clock
  cv::Mat pixels_[kCamerasMax];
  ViewImage images_[kCamerasMax];
  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<bool> busy_{false};
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace pirvs::tools
