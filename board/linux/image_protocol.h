// What pirvsd and a program that wants its images tell each other, by messages of a Unix socket
// (SOCK_SEQPACKET): one ImageRing with the ring's memory (SCM_RIGHTS) to whoever connects, then
// ImageReady for each image, and from the other side ImageRequest.
// In      A request says which cameras are wanted from now on, by bit, and gives back a slot.
// Out     An image lies in its slot, rows without a gap, until the slot is given back.
// Units   t: ns of CLOCK_MONOTONIC, middle of the exposure.
// Errors  A client that says what makes no sense is disconnected. While no slot is free images are
//         lost, and the next one tells how many.
// Source  docs/device.md, "Images for other programs".
#pragma once

#include <cstdint>

namespace pirvs::board {

inline constexpr uint32_t kImageMagic = 0x31495650;  // "PVI1"

struct ImageRing {
  uint32_t magic = kImageMagic;
  uint32_t cameras = 0;
  uint32_t width = 0, height = 0;
  uint32_t slots = 0, slot_bytes = 0;  // slot i begins at i * slot_bytes
};

struct ImageReady {
  int64_t t = 0;
  uint32_t slot = 0, camera = 0;
  uint32_t sequence = 0;  // the camera's own count of images
  uint32_t lost = 0;      // wanted since the connection began, and never sent
};

struct ImageRequest {
  static constexpr uint32_t kNoSlot = 0xffff'ffff;
  uint32_t cameras = 0;
  uint32_t slot = kNoSlot;
};

}  // namespace pirvs::board
