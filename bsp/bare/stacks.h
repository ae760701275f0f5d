// The cores' stacks, as linker/bare.ld lays them out and start.S sets them.
// In      core: 0 and on.
// Out     stack_of: where its C++ runs. guard_of: the page below, which is not mapped.
//         stack_used: the most that has been in use since stacks_paint.
// Errors  none.
// Cost    stack_used reads the unused part once.
// Source  linker/bare.ld.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::bsp {

struct AddressRange {
  uintptr_t begin;
  uintptr_t end;

  bool holds(uintptr_t address) const { return address >= begin && address < end; }
  size_t size() const { return end - begin; }
};

AddressRange stack_of(int core);
AddressRange guard_of(int core);
void stacks_paint();  // on core 0, before others run
size_t stack_used(int core);

}  // namespace pirvs::bsp
