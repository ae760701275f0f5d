#include "bsp/bare/stacks.h"

#include "bsp/bare/machine.h"
#include "bsp/bare/registers.h"

extern "C" char __stacks_begin[], __stack_bytes[], __exception_stack_bytes[];

namespace pirvs::bsp {
namespace {

constexpr uintptr_t kPage = 4096;
constexpr uint64_t kPaint = 0x5ca1ab1e5ca1ab1e;

}  // namespace

// Upwards: guard, stack, guard, exception stack.
AddressRange guard_of(int core) {
  const auto stack = reinterpret_cast<uintptr_t>(__stack_bytes);
  const auto exception_stack = reinterpret_cast<uintptr_t>(__exception_stack_bytes);
  const uintptr_t begin = reinterpret_cast<uintptr_t>(__stacks_begin) +
                          static_cast<uintptr_t>(core) * (stack + exception_stack + 2 * kPage);
  return {begin, begin + kPage};
}

AddressRange stack_of(int core) {
  const uintptr_t begin = guard_of(core).end;
  return {begin, begin + reinterpret_cast<uintptr_t>(__stack_bytes)};
}

void stacks_paint() {
  const auto here = reinterpret_cast<uintptr_t>(__builtin_frame_address(0));
  for (int core = 0; core < kMachine.cores; ++core) {
    const AddressRange stack = stack_of(core);
    const uintptr_t end = core == this_core() ? here - 512 : stack.end;  // 512: what is in use
    for (uintptr_t at = stack.begin; at + 8 <= end; at += 8) {
      *reinterpret_cast<volatile uint64_t*>(at) = kPaint;
    }
  }
}

size_t stack_used(int core) {
  const AddressRange stack = stack_of(core);
  uintptr_t at = stack.begin;
  while (at < stack.end && *reinterpret_cast<volatile uint64_t*>(at) == kPaint) at += 8;
  return stack.end - at;
}

}  // namespace pirvs::bsp
