// Calls to the firmware by PSCI: cores on and off, reset.
// In      How it is called (device tree); a core's MPIDR; where it shall begin.
// Out     Status; core_off and machine_reset do not come back.
// Errors  kBusFault: the firmware refuses. kFull: the core is on already.
// Cost    Microseconds in the firmware.
// Source  Arm Power State Coordination Interface, DEN 0022.
#pragma once

#include <cstdint>

#include "bsp/drivers/device_tree/device_tree.h"

namespace pirvs::bsp {

void firmware_start(FirmwareCall call);  // kUnknown: what fits the level that we were started at
Status firmware_core_on(uint64_t mpidr, uintptr_t entry, uint64_t argument);
bool firmware_core_is_off(uint64_t mpidr);
[[noreturn]] void firmware_core_off();  // this one
[[noreturn]] void firmware_reset();

}  // namespace pirvs::bsp
