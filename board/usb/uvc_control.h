// What a USB camera answers its host: PROBE and COMMIT of the one format that there is, 8-bit grey
// of one size and rate. Requests and answers alone, without a device.
// In      A control request. What a host sets is not looked at: there is one thing to choose.
// Out     The answer, as UVCIOC_SEND_RESPONSE takes it.
// Units   Intervals in 100 ns, as USB has them.
// Errors  A request that is not known is refused (a stall), and the host that asks why is told so.
// Cost    nanoseconds.
// Source  USB Video Class 1.1, 4.2.1.2 (error code), 4.3.1.1 (probe and commit), table A-8.
#pragma once

#include <linux/usb/ch9.h>
#include <linux/usb/g_uvc.h>
#include <linux/usb/video.h>

#include <cstdint>

namespace pirvs::board {

struct UvcFormat {
  int width = 0, height = 0;
  uint32_t interval = 166'666;
  uint32_t payload_max = 3072;
  // As the kernel has numbered them.
  uint8_t control_interface = 0, streaming_interface = 1;
};

class UvcControl {
 public:
  void configure(const UvcFormat& format);

  uvc_request_data answer(const usb_ctrlrequest& request) const;

 private:
  uvc_request_data streaming(const usb_ctrlrequest& request, uint8_t selector) const;

  UvcFormat format_;
  uvc_streaming_control offer_{};
};

}  // namespace pirvs::board
