// Registers of a memory-mapped chip as rows, with the names of the chip's own manual.
// In      Rows: name, offset from the chip's base, how an access behaves, value after reset. A
//         driver's table is also what its emulator runs on (emulated/register_file.h).
// Out     Registers: reads and writes by row. A static_assert on is_table() keeps a table sorted,
//         aligned and free of double entries.
// Errors  none; see bsp/api/mmio.h.
// Cost    As mmio: one access to device memory each. The row is folded into an address.
// Source  STYLE principle 13; RK3399 TRM part 1, "GRF": the upper 16 bits of a word say which of
//         the lower 16 are written.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/api/mmio.h"

namespace pirvs::bsp {

enum class Access : uint8_t {
  kReadWrite,
  kReadOnly,
  kWriteOnly,   // reads as 0
  kClearByOne,  // a 1 written clears the bit
  kHiwordMask,  // bits 31..16 select which of bits 15..0 change; they read as 0
};

struct Register {
  const char* name;
  uint32_t offset;
  Access access;
  uint32_t reset;
};

template <size_t N>
constexpr bool is_table(const Register (&rows)[N]) {
  for (size_t i = 0; i < N; ++i) {
    if (rows[i].offset % 4 != 0) return false;
    if (i > 0 && rows[i].offset <= rows[i - 1].offset) return false;
  }
  return true;
}

// The word that sets the bits of `mask` to those of `value` in a kHiwordMask register.
constexpr uint32_t hiword(uint32_t mask, uint32_t value) { return mask << 16 | (value & mask); }

class Registers {
 public:
  constexpr explicit Registers(uintptr_t base) : base_(base) {}

  uint32_t read(const Register& row) const { return mmio_read32(base_ + row.offset); }
  void write(const Register& row, uint32_t value) const { mmio_write32(base_ + row.offset, value); }
  // Reads, replaces the bits of `mask`, writes: not atomic.
  void change(const Register& row, uint32_t mask, uint32_t value) const {
    write(row, (read(row) & ~mask) | (value & mask));
  }
  // Element `index` of an array of registers that begins at `row`.
  uint32_t read_at(const Register& row, uint32_t index) const {
    return mmio_read32(base_ + row.offset + 4 * index);
  }
  void write_at(const Register& row, uint32_t index, uint32_t value) const {
    mmio_write32(base_ + row.offset + 4 * index, value);
  }

 private:
  uintptr_t base_;
};

}  // namespace pirvs::bsp
