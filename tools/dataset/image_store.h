// What    Where a recording's images are that are no files: within a log, a video.
// In      What FrameFiles::image says of one.
// Out     8-bit grey. From one thread, the player's.
// Errors  Read: what became of the image; the player counts it.
// Cost    that of decoding.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

namespace pirvs::tools {

enum class ImageRead : uint8_t { kGood, kMissing, kCutOff, kUndecodable, kWrongSize, kCount };

class ImageStore {
 public:
  virtual ~ImageStore() = default;
  virtual ImageRead read(const std::string& key, cv::Mat& grey) = 0;
};

}  // namespace pirvs::tools
