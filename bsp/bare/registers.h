// System registers of AArch64 by their names in the Arm ARM.
// In      PIRVS_READ(name), PIRVS_WRITE(name, value).
// Out     The register's value.
// Errors  A register that this core does not have ends in a fault report.
// Cost    One instruction.
// Source  Arm ARM D13; GICv3 specification, IHI 0069, for ICC_*.
#pragma once

#include <cstdint>

#define PIRVS_READ(name)                                          \
  ([] {                                                           \
    uint64_t pirvs_value;                                         \
    asm volatile("mrs %0, " #name : "=r"(pirvs_value)::"memory"); \
    return pirvs_value;                                           \
  }())
#define PIRVS_WRITE(name, value) \
  asm volatile("msr " #name ", %0" ::"r"(static_cast<uint64_t>(value)) : "memory")

namespace pirvs::bsp {

inline int this_core() { return static_cast<int>(PIRVS_READ(tpidr_el1)); }
inline void mask_interrupts() { asm volatile("msr daifset, #0xf" ::: "memory"); }
inline void unmask_interrupts() { asm volatile("msr daifclr, #0xf" ::: "memory"); }

}  // namespace pirvs::bsp
