#include "board/usb/uvc_control.h"

#include <endian.h>
#include <errno.h>

#include <algorithm>
#include <cstring>

namespace pirvs::board {
namespace {

constexpr uint8_t kInvalidControl = 0x06;
constexpr uint8_t kCanGet = 1, kCanSet = 2;
constexpr uint16_t kProbeBytes = 34;  // of UVC 1.1
static_assert(sizeof(uvc_streaming_control) == kProbeBytes);

uvc_request_data refusal() {
  uvc_request_data out{};
  out.length = -EL2HLT;
  return out;
}

uvc_request_data bytes(const void* data, size_t size) {
  uvc_request_data out{};
  out.length = static_cast<int32_t>(std::min(size, sizeof out.data));
  std::memcpy(out.data, data, static_cast<size_t>(out.length));
  return out;
}

uvc_request_data byte(uint8_t value) { return bytes(&value, 1); }

}  // namespace

void UvcControl::configure(const UvcFormat& format) {
  format_ = format;
  offer_ = {};
  offer_.bmHint = htole16(1);  // the interval stays
  offer_.bFormatIndex = 1;
  offer_.bFrameIndex = 1;
  offer_.dwFrameInterval = htole32(format.interval);
  offer_.dwMaxVideoFrameSize = htole32(static_cast<uint32_t>(format.width * format.height));
  offer_.dwMaxPayloadTransferSize = htole32(format.payload_max);
  offer_.bmFramingInfo = 3;  // the payload's header says frame and end of frame
  offer_.bPreferedVersion = 1;
  offer_.bMaxVersion = 1;
}

// The low byte names the interface, the high byte the entity within: 0 is the interface itself.
uvc_request_data UvcControl::answer(const usb_ctrlrequest& request) const {
  const bool to_interface = (request.bRequestType & USB_TYPE_MASK) == USB_TYPE_CLASS &&
                            (request.bRequestType & USB_RECIP_MASK) == USB_RECIP_INTERFACE;
  const uint16_t index = le16toh(request.wIndex);
  const auto selector = static_cast<uint8_t>(le16toh(request.wValue) >> 8);
  if (!to_interface || index >> 8 != 0) return refusal();
  if (index == format_.streaming_interface) return streaming(request, selector);
  const bool asks_why = index == format_.control_interface &&
                        selector == UVC_VC_REQUEST_ERROR_CODE_CONTROL &&
                        request.bRequest == UVC_GET_CUR;
  return asks_why ? byte(kInvalidControl) : refusal();
}

uvc_request_data UvcControl::streaming(const usb_ctrlrequest& request, uint8_t selector) const {
  if (selector != UVC_VS_PROBE_CONTROL && selector != UVC_VS_COMMIT_CONTROL) return refusal();
  const size_t wanted = std::min<size_t>(le16toh(request.wLength), sizeof offer_);
  switch (request.bRequest) {
    case UVC_SET_CUR: {
      uvc_request_data out{};
      out.length = static_cast<int32_t>(wanted);  // so many bytes will be taken
      return out;
    }
    case UVC_GET_CUR:
    case UVC_GET_MIN:
    case UVC_GET_MAX:
    case UVC_GET_DEF:
      return bytes(&offer_, wanted);
    case UVC_GET_LEN: {
      const uint16_t length = htole16(kProbeBytes);
      return bytes(&length, sizeof length);
    }
    case UVC_GET_INFO:
      return byte(kCanGet | kCanSet);
    default:
      return refusal();
  }
}

}  // namespace pirvs::board
