// What a board without an operating system tells bsp/bare about its chip; defined once in
// board/<name>/machine.cc.
// In, Out one constant, kMachine.
// Errors  A wrong address ends in a fault report, or in silence if it is the console's.
// Source  The chip's manual; QEMU's hw/arm/virt.c for `virt`.
#pragma once

#include <cstdint>

#include "bsp/api/cores.h"

namespace pirvs::bsp {

struct Machine {
  const char* name;
  // The console. Characters wait inside uart_write for as long as the chip has no room.
  void (*uart_start)();
  void (*uart_write)(char c);
  int (*uart_read)();  // -1: nothing has come
  uintptr_t gicd;      // GICv3 distributor
  uintptr_t gicr;      // first redistributor; one every 128 KiB
  int cores;
  uint64_t mpidr[kCoresMax];  // affinity of core i; core 0 is the one that boots
  uintptr_t device_tree;      // where a loader leaves it that passes no address; 0: nowhere
  bool emulated;              // then cycles are not a processor's own
};

extern const Machine kMachine;

}  // namespace pirvs::bsp
