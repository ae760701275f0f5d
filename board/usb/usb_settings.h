// What the device is on USB: the keys `usb.` of its configuration file, and where its images come
// from. pirvsd reads the same file and finds their faults, too.
// In      The text. Keys:
//           usb.video = left              or right, none: the camera that a host sees
//           usb.size = 640 480            pixels: as the calibration has them
//           usb.rate_hz = 60              of the camera, as the host is told
//           usb.serial = 0001             default: the board's own, else made of /etc/machine-id
//           output.images = /run/pirvs/images    pirvsd's socket (board/linux/image_share.h)
// Out     What is set, defaults else; other keys are pirvsd's.
// Units   pixels, Hz.
// Errors  A fault with its line.
// Cost    microseconds, at start. No heap.
// Source  docs/device.md, "USB".
#pragma once

#include <string_view>

#include "core/config/key_values.h"

namespace pirvs::board {

enum class UsbVideo : uint8_t { kLeft, kRight, kNone };

struct UsbSettings {
  static constexpr size_t kSerialMax = 32;

  UsbVideo video = UsbVideo::kLeft;
  int width = 640, height = 480;
  double rate_hz = 60;
  char serial[kSerialMax + 1] = "";
  char images[96] = "/run/pirvs/images";
};

// True: the key is one of these, whoever reads the file.
[[nodiscard]] bool is_usb_key(std::string_view key);
// One `key = value`: nullptr, or what is wrong.
[[nodiscard]] const char* set_usb_setting(UsbSettings& settings, std::string_view key,
                                          std::string_view value);
[[nodiscard]] ConfigFault read_usb_settings(std::string_view text, UsbSettings& out);

}  // namespace pirvs::board
