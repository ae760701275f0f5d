// The device as a USB gadget, by the kernel's configfs: network (NCM), serial line (ACM) and camera
// (UVC, 8-bit grey), one row a folder, attribute or link, made in order and taken away in reverse.
// In      GadgetSetup; the root of configfs; a UDC's name.
// Out     make(): all of it, bound to the UDC: a host sees it at once, or with a camera, as soon as
//         the camera's node is held (uvc_holder.h). remove(): nothing is left of it, or of what a
//         killed predecessor has left. The kernel calls the network's interface usb0, the first
//         free one of usb%d.
// Errors  make: the row that the kernel refused, errno says why, and what was made before it is
//         gone again; nullptr: none. remove: what is not there is no fault.
// Cost    ~60 system calls, and up to a second that the kernel waits for the camera's node.
// Source  Linux, Documentation/usb/gadget_configfs, ABI/testing/configfs-usb-gadget-*; USB Video
//         Class 1.1, "Uncompressed Payload".
#pragma once

#include <cstdint>

#include "board/usb/usb_settings.h"

namespace pirvs::board {

// The calls that configfs is made of, as a table: a test gives its own. 0, or -1 and errno.
struct FolderCalls {
  int (*make_folder)(const char* path);
  int (*remove_folder)(const char* path);
  int (*make_link)(const char* target, const char* path);
  int (*remove_link)(const char* path);
  int (*write_file)(const char* path, const void* data, size_t size);
};
extern const FolderCalls kFolderCalls;

struct MacAddress {
  char text[18];  // 02:00:00:00:00:00
};

struct GadgetSetup {
  UsbSettings usb;
  char serial[UsbSettings::kSerialMax + 1] = "";
  const char* udc = "";  // as /sys/class/udc lists it
};

// Of the device's own end, and of the host's: the same for the same serial number, locally
// administered.
MacAddress mac_address(const char* serial, bool host);
// 16 hexadecimal digits that tell devices apart and do not give the text away.
void put_digest(const char* text, char* out);

class Gadget {
 public:
  Gadget(const char* configfs, const FolderCalls& calls = kFolderCalls)
      : configfs_(configfs), calls_(&calls) {}

  [[nodiscard]] const char* make(const GadgetSetup& setup) const;
  void remove() const;

 private:
  const char* configfs_;
  const FolderCalls* calls_;
};

}  // namespace pirvs::board
