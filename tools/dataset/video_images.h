// What    The frames of videos as a recording's images.
// In      One video a camera. Keys: key_of(camera, frame), frames from 0 on.
// Out     8-bit grey, as OpenCV's FFmpeg decodes it, turned as the video says that it is.
// Errors  InputError: cannot be opened. kMissing: behind the video's end.
// Cost    that of decoding all frames in between; backwards, all from the begin.
#pragma once

#include <memory>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "tools/dataset/image_store.h"

namespace pirvs::tools {

class VideoImages : public ImageStore {
 public:
  explicit VideoImages(const std::vector<std::string>& paths);
  static std::string key_of(size_t camera, size_t frame);
  ImageRead read(const std::string& key, cv::Mat& grey) override;
  // As the video's head tells; 0: it does not.
  size_t frames(size_t camera) const;

 private:
  struct Video {
    std::string path;
    std::unique_ptr<cv::VideoCapture> capture;
    size_t next = 0;
  };
  std::vector<Video> videos_;

  static void open(Video& video);
};

}  // namespace pirvs::tools
