// The few facts that a loader hands over in a flattened device tree.
// In      The blob, or anything else: it is looked at with suspicion.
// Out     Memory of the recording (linux,initrd-start, -end), the command line (bootargs), how the
//         firmware is called (psci method). What is not there stays zero, empty or kUnknown.
// Errors  kNotFound: no tree there. kBadData: cut off or damaged; out holds what came before.
// Cost    One pass, ~10 us.
// Source  Devicetree Specification 0.4, chapter 5 (flattened format), 3.6 (chosen).
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/status.h"

namespace pirvs::bsp {

enum class FirmwareCall : uint8_t { kUnknown, kHvc, kSmc };

struct DeviceTree {
  static constexpr size_t kArgumentsMax = 512;

  uint64_t initrd_begin = 0;
  uint64_t initrd_end = 0;
  uint64_t bytes = 0;  // of the tree itself
  FirmwareCall firmware = FirmwareCall::kUnknown;
  char arguments[kArgumentsMax] = {};
};

// blob may be null; it is read up to its own size, at most kDeviceTreeMax.
inline constexpr size_t kDeviceTreeMax = 2u << 20;
Status read_device_tree(const void* blob, DeviceTree& out);

// The value of "name=value" among words parted by spaces, or of a bare "name" (an empty value).
// False: the word is not there. A value that does not fit is cut.
bool find_argument(const char* arguments, const char* name, char* value, size_t size);

}  // namespace pirvs::bsp
