#include "bsp/api/cycles.h"

#include "bsp/bare/core_setup.h"
#include "bsp/bare/machine.h"
#include "bsp/bare/registers.h"

namespace pirvs::bsp {
namespace {

constexpr uint64_t kPmcrE = 1u << 0;   // on
constexpr uint64_t kPmcrP = 1u << 1;   // events to zero
constexpr uint64_t kPmcrC = 1u << 2;   // cycles to zero
constexpr uint64_t kPmcrLc = 1u << 6;  // 64 bits of cycles
constexpr uint64_t kInstRetired = 0x08;
constexpr uint64_t kEnableCycles = 1u << 31;
constexpr uint64_t kEnableEvent0 = 1u << 0;

}  // namespace

void cycles_start_core() {
  PIRVS_WRITE(pmcr_el0, kPmcrE | kPmcrP | kPmcrC | kPmcrLc);
  PIRVS_WRITE(pmccfiltr_el0, 0);
  PIRVS_WRITE(pmevtyper0_el0, kInstRetired);
  PIRVS_WRITE(pmcntenset_el0, kEnableCycles | kEnableEvent0);
  asm volatile("isb");
}

Cycles read_cycles() {
  asm volatile("isb" ::: "memory");
  return {PIRVS_READ(pmccntr_el0), PIRVS_READ(pmevcntr0_el0)};  // events: 32 bits, they wrap
}

bool cycles_are_real() { return !kMachine.emulated; }

}  // namespace pirvs::bsp
