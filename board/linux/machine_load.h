// What this program costs the machine, and how hot it is, as counters: cpu_ms since the start,
// temperature_mC of the first thermal zone.
// In      open(): finds the zone. for_each_counter(): a few times a second at most, one core.
// Errors  a machine without a zone has no temperature: it is not told.
// Cost    two system calls; on an RK3399 a conversion of its sensor, below 1 ms.
// Source  Linux, Documentation/driver-api/thermal/sysfs-api.rst; getrusage(2).
#pragma once

#include <cstdint>

namespace pirvs::board {

class MachineLoad {
 public:
  void open();
  void close();
  void for_each_counter(void (*visit)(const char* name, uint64_t value)) const;

 private:
  int zone_fd_ = -1;
};

}  // namespace pirvs::board
