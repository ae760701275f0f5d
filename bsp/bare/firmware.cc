#include "bsp/bare/firmware.h"

#include "bsp/bare/registers.h"

extern "C" uint64_t boot_registers[2];  // start.S: device tree, CurrentEL

namespace pirvs::bsp {
namespace {

enum Function : uint64_t {
  kCpuOff = 0x84000002,
  kSystemReset = 0x84000009,
  kCpuOn = 0xc4000003,
  kAffinityInfo = 0xc4000004,
};
constexpr int64_t kSuccess = 0;
constexpr int64_t kAlreadyOn = -4;
constexpr int64_t kAffinityOff = 1;
constexpr uint64_t kEl2 = 2 << 2;

// Kept: the core that orders a restart still needs it while core 0 zeroes the memory.
[[gnu::section(".kept")]] FirmwareCall firmware_call;

int64_t ask(Function function, uint64_t a = 0, uint64_t b = 0, uint64_t c = 0) {
  register uint64_t x0 asm("x0") = function;
  register uint64_t x1 asm("x1") = a;
  register uint64_t x2 asm("x2") = b;
  register uint64_t x3 asm("x3") = c;
  // SMC Calling Convention 1.0: x4 to x17 may be lost.
  if (firmware_call == FirmwareCall::kHvc) {
    asm volatile("hvc #0"
                 : "+r"(x0), "+r"(x1), "+r"(x2), "+r"(x3)::"memory", "x4", "x5", "x6", "x7", "x8",
                   "x9", "x10", "x11", "x12", "x13", "x14", "x15", "x16", "x17");
  } else {
    asm volatile("smc #0"
                 : "+r"(x0), "+r"(x1), "+r"(x2), "+r"(x3)::"memory", "x4", "x5", "x6", "x7", "x8",
                   "x9", "x10", "x11", "x12", "x13", "x14", "x15", "x16", "x17");
  }
  // The 32-bit functions answer in w0; all answers are small numbers.
  return static_cast<int32_t>(x0);
}

[[noreturn]] void rest_for_ever() {
  for (;;) asm volatile("wfi");
}

}  // namespace

void firmware_start(FirmwareCall call) {
  const bool from_el2 = boot_registers[1] == kEl2;
  firmware_call = call != FirmwareCall::kUnknown ? call
                  : from_el2                     ? FirmwareCall::kSmc
                                                 : FirmwareCall::kHvc;
}

Status firmware_core_on(uint64_t mpidr, uintptr_t entry, uint64_t argument) {
  const int64_t answer = ask(kCpuOn, mpidr, entry, argument);
  if (answer == kSuccess) return Status::kOk;
  return answer == kAlreadyOn ? Status::kFull : Status::kBusFault;
}

bool firmware_core_is_off(uint64_t mpidr) { return ask(kAffinityInfo, mpidr, 0) == kAffinityOff; }

void firmware_core_off() {
  mask_interrupts();
  ask(kCpuOff);
  rest_for_ever();
}

void firmware_reset() {
  mask_interrupts();
  ask(kSystemReset);
  rest_for_ever();
}

}  // namespace pirvs::bsp
