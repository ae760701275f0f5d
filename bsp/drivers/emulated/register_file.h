// The memory behind an emulated chip: a driver's own table, with the access rule of each row.
// In      The table (at most kRowsMax rows); accesses of the driver; values of the chip itself.
// Out     load and store as the driver sees them, by the row's rule; peek and poke as the chip
//         does, without rules.
// Errors  Offset that is in no row, a write to a read-only register or a read of a write-only one:
//         a bug of the driver, asserts.
// Cost    A search through the table.
// Source  bsp/drivers/register.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/drivers/register.h"
#include "core/base/assert.h"

namespace pirvs::bsp::emulated {

class RegisterFile {
 public:
  static constexpr size_t kRowsMax = 40;

  template <size_t N>
  explicit RegisterFile(const Register (&rows)[N]) : rows_(rows), count_(N) {
    static_assert(N <= kRowsMax);
    reset();
  }

  void reset() {
    for (size_t i = 0; i < count_; ++i) values_[i] = rows_[i].reset;
  }

  uint32_t load(uint32_t offset) const {
    const size_t i = index_of(offset);
    PIRVS_ASSERT(rows_[i].access != Access::kWriteOnly);
    return values_[i];
  }

  void store(uint32_t offset, uint32_t value) {
    const size_t i = index_of(offset);
    switch (rows_[i].access) {
      case Access::kReadOnly:
        PIRVS_ASSERT(!"a read-only register is not written");
        break;
      case Access::kReadWrite:
      case Access::kWriteOnly:
        values_[i] = value;
        break;
      case Access::kClearByOne:
        values_[i] &= ~value;
        break;
      case Access::kHiwordMask:
        values_[i] = (values_[i] & ~(value >> 16)) | (value & value >> 16);
        break;
    }
  }

  uint32_t peek(const Register& row) const { return values_[index_of(row.offset)]; }
  void poke(const Register& row, uint32_t value) { values_[index_of(row.offset)] = value; }

 private:
  size_t index_of(uint32_t offset) const {
    size_t i = 0;
    while (i < count_ && rows_[i].offset != offset) ++i;
    PIRVS_ASSERT(i < count_);
    return i;
  }

  const Register* rows_;
  size_t count_;
  uint32_t values_[kRowsMax];
};

}  // namespace pirvs::bsp::emulated
