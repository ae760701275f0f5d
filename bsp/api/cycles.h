// Cycle and instruction counters of this core, for profiles.
// Out     Counts since start; only differences on one core mean something. cycles_are_real():
//         true: a processor's own counter. false: an emulator's or a stand-in; say so beside every
//         number. On QEMU with -icount both count instructions, those of all cores together.
// Errors  A machine without counters gives nanoseconds as cycles and 0 instructions.
// Cost    ~10 cycles bare metal.
// Source  Arm ARM D8 (PMUv3): PMCCNTR_EL0, event 0x08 INST_RETIRED.
#pragma once

#include <cstdint>

namespace pirvs::bsp {

struct Cycles {
  uint64_t cycles = 0;
  uint64_t instructions = 0;
};

Cycles read_cycles();
bool cycles_are_real();

}  // namespace pirvs::bsp
