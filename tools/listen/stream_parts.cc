#include "tools/listen/stream_parts.h"

#include <algorithm>
#include <sstream>

namespace pirvs::tools {

size_t SequenceGaps::next(uint32_t sequence) {
  const auto step = has_sequence_ ? static_cast<int32_t>(sequence - sequence_) : 1;
  has_sequence_ = true;
  sequence_ = sequence;
  return step > 1 ? static_cast<size_t>(step - 1) : 0;
}

// Parts of another image end the one before.
const ImageParts::Image* ImageParts::add(const stream::ThumbnailMessage& part) {
  if (part.t != image_.t || part.width != image_.width || part.height != image_.height) {
    image_ = {part.t, part.width, part.height, {}};
    image_.pixels.resize(size_t{part.width} * part.height);
    filled_ = 0;
  }
  if (size_t{part.offset} + part.count > image_.pixels.size()) return nullptr;
  std::copy_n(part.pixels, part.count, image_.pixels.begin() + part.offset);
  filled_ += part.count;
  return filled_ == image_.pixels.size() && filled_ > 0 ? &image_ : nullptr;
}

void read_counters(const stream::Header& header, const uint8_t* payload,
                   std::map<std::string, uint64_t>& out) {
  std::istringstream lines(std::string(reinterpret_cast<const char*>(payload), header.size));
  std::string name;
  uint64_t value = 0;
  while (lines >> name >> value) out[name] = value;
}

}  // namespace pirvs::tools
