// What    A device's stream (docs/device.md), as a view shows it.
// In      HOST[:PORT], or a file of `pirvs listen --record`, which is played at its own pace; a tty
//         for commands, or none.
// Out     to the scene: poses, points, health, counters, thumbnails, poses on the Earth. Until
//         `stop`. A device that goes is waited for, and asked again when it comes.
// Errors  InputError: a file that is no stream. A host without an address is asked for again.
// Cost    a few percent of a core at 200 poses a second.
#pragma once

#include <csignal>
#include <string>

#include "tools/view/view.h"

namespace pirvs::tools {

struct DeviceViewOptions {
  std::string from;
  std::string serial;
};

void view_device(View& view, const DeviceViewOptions& options,
                 const volatile std::sig_atomic_t& stop);

}  // namespace pirvs::tools
