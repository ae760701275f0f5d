// Feeds the gadget's camera with pirvsd's images, while a host looks. A process of its own, which
// may be killed at any time: uvc_holder.h has the node, and starts another one.
// In      The holder's open node; a pipe by which it says 1: a host takes images, or 0.
// Out     Each image that pirvsd gives is queued for the host; without a host none is asked for.
//         run() returns when the holder is gone.
// Errors  An image for which no buffer is free is dropped: the bus takes its time for those before.
//         While pirvsd is not there, it is asked twice a second. What a person should know comes as
//         a line by FeederSetup::tell, once.
// Cost    A copy of the image, four system calls. No heap.
// Source  V4L2 API, "Streaming I/O (Memory Mapping)".
#pragma once

#include "board/usb/image_client.h"
#include "board/usb/uvc_holder.h"

namespace pirvs::board {

struct FeederSetup {
  int node = -1, control = -1;
  const char* images = "";  // pirvsd's socket
  int camera = 0;
  int width = 0, height = 0;
  void (*tell)(const char* what) = nullptr;
};

class UvcFeeder {
 public:
  // False: the node's buffers cannot be had.
  [[nodiscard]] bool open(const FeederSetup& setup,
                          const bsp::SystemCalls& calls = bsp::kSystemCalls);
  void run();

 private:
  bool obey_holder();
  void follow_stream();
  void take_images();
  void look_at_buffers();
  void take_back();
  bool show(const uint8_t* pixels);
  void tell(const char* what);
  size_t bytes() const {
    return static_cast<size_t>(setup_.width) * static_cast<size_t>(setup_.height);
  }

  FeederSetup setup_;
  const bsp::SystemCalls* calls_ = &bsp::kSystemCalls;
  ImageClient client_;
  uint8_t* buffers_[kUvcBuffers] = {};
  bool queued_[kUvcBuffers] = {};
  bool streaming_ = false;
  const char* told_ = nullptr;
};

}  // namespace pirvs::board
