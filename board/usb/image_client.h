// Takes images from pirvsd, the other side of board/linux/image_share.h.
// In      connect(): the socket's path, which camera. next(): when fd() is readable.
// Out     next(): an image, valid until give_back(). Its pixels lie row by row without a gap.
// Errors  connect: kNotFound: pirvsd is not there; kBadData: it talks otherwise; kBusFault. next:
//         kEmpty: nothing now; kStale: pirvsd has gone, and so has the connection.
// Cost    A system call an image, and one to give it back. No copy, no heap.
// Source  board/linux/image_protocol.h.
#pragma once

#include <cstddef>

#include "board/linux/image_protocol.h"
#include "core/base/status.h"

namespace pirvs::board {

class ImageClient {
 public:
  Status connect(const char* path, int camera);
  Status next(ImageReady& out);
  void give_back(const ImageReady& image);
  void close();

  bool is_open() const { return fd_ >= 0; }
  int fd() const { return fd_; }
  const ImageRing& ring() const { return ring_; }
  const uint8_t* pixels(const ImageReady& image) const {
    return memory_ + size_t{image.slot} * ring_.slot_bytes;
  }

 private:
  Status receive_ring();
  bool ask(uint32_t slot);
  size_t memory_bytes() const { return size_t{ring_.slots} * ring_.slot_bytes; }

  int fd_ = -1;
  uint32_t cameras_ = 0;
  const uint8_t* memory_ = nullptr;
  ImageRing ring_;
};

}  // namespace pirvs::board
