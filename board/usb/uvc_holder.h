// Holds the node of the gadget's camera: as long as it is open the host sees the gadget, so whoever
// holds it does nothing else. Answers the host's requests, and starts and stops the stream; images
// are queued by another process, which has the same open node (uvc_feeder.h).
// In      open(): the node; its events end a poll() for POLLPRI, then on_events().
// Out     streaming(): a host takes images.
// Errors  open: what is wrong, errno says why; nullptr: it is held. on_events: false: the node is
//         gone. The kernel's refusals of single answers are counted.
// Cost    Two system calls an event. No heap.
// Source  Linux, include/uapi/linux/usb/g_uvc.h, drivers/usb/gadget/function/uvc_v4l2.c. The stream
//         is started here and at once: until then the host's request has no answer, and those of
//         network and serial line wait behind it.
#pragma once

#include "board/usb/uvc_control.h"
#include "bsp/linux/system_calls.h"
#include "core/base/counter.h"

namespace pirvs::board {

inline constexpr uint32_t kUvcBuffers = 4;

class UvcHolder {
 public:
  [[nodiscard]] const char* open(const char* path, const UvcFormat& format,
                                 const bsp::SystemCalls& calls = bsp::kSystemCalls);
  [[nodiscard]] bool on_events();
  void close();

  int fd() const { return fd_; }
  bool streaming() const { return streaming_; }
  uint32_t refused() const { return refused_; }

 private:
  bool stream(bool on);

  const bsp::SystemCalls* calls_ = &bsp::kSystemCalls;
  UvcControl control_;
  int fd_ = -1;
  bool streaming_ = false;
  Counter refused_;
};

}  // namespace pirvs::board
