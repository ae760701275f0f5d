// What    How busy this machine is, for the page.
// In      /proc/stat, getrusage, /proc/self/statm, /sys/class/thermal.
// Out     JSON: cpu of this program (1: one core) and of the machine (1: all cores) since the last
//         call, cores, memory in MB, temperature in degrees C of the hottest zone.
// Errors  what the machine does not tell is null.
// Cost    ~0.1 ms.
#pragma once

#include <nlohmann/json.hpp>

#include "core/base/time.h"

namespace pirvs::tools {

class SystemLoad {
 public:
  nlohmann::json measure();

 private:
  TimeNs t_ = 0;
  double used_s_ = 0;                          // CPU time of this program
  double machine_busy_ = 0, machine_all_ = 0;  // ticks
};

}  // namespace pirvs::tools
