// What    What every listener does with datagrams: counts those that were lost, puts images
//         together, reads counters.
// In      Datagrams in the order in which they came, decoded.
// Errors  none: what is missing of an image was lost, and the next one begins anew.
// Source  modules/stream/stream.h.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "modules/stream/stream.h"

namespace pirvs::tools {

class SequenceGaps {
 public:
  // How many were lost between the datagram before and this one.
  size_t next(uint32_t sequence);

 private:
  bool has_sequence_ = false;
  uint32_t sequence_ = 0;
};

class ImageParts {
 public:
  struct Image {
    TimeNs t = 0;
    int width = 0, height = 0;
    std::vector<uint8_t> pixels;
  };
  // The image that this part makes whole, until the next call; else nullptr.
  const Image* add(const stream::ThumbnailMessage& part);

 private:
  Image image_;
  size_t filled_ = 0;
};

void read_counters(const stream::Header& header, const uint8_t* payload,
                   std::map<std::string, uint64_t>& out);

}  // namespace pirvs::tools
