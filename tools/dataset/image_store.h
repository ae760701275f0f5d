// What    Where a recording's images are that are no files: within a log, a video.
// In      What FrameFiles::image says of one.
// Out     8-bit grey; or the image as a file would hold it. From one thread, the player's.
// Errors  Read: what became of the image; the player counts it.
// Cost    that of decoding.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace pirvs::tools {

enum class ImageRead : uint8_t { kGood, kMissing, kCutOff, kUndecodable, kWrongSize, kCount };

// As a file has it: JPEG, PNG, ...
struct EncodedImage {
  std::vector<uint8_t> bytes;
  std::string format;  // "jpeg", "png": without a dot; empty: none
};

class ImageStore {
 public:
  virtual ~ImageStore() = default;
  virtual ImageRead read(const std::string& key, cv::Mat& grey) = 0;
  // Nothing where the store does not keep it so.
  virtual EncodedImage encoded(const std::string&) { return {}; }
};

}  // namespace pirvs::tools
