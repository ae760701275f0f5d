// Set-up of the RK3399 around its controllers, as data: which function a pin has, which clocks run.
// In      Rows: a register of GRF, PMUGRF, CRU or PMUCRU, the bits that matter, their value, why.
// Out     apply: writes them in order. holds: reads them back, so that a reset or another master's
//         change is seen.
// Frames  none.
// Errors  kBadData: a row does not hold; `which` says the first.
// Cost    One access a row.
// Source  RK3399 TRM V1.3 part 1, chapters "GRF" and "CRU". Each register takes 16 bits and, above
//         them, the mask of those that change: no row touches what another one set.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/drivers/register.h"
#include "core/base/status.h"

namespace pirvs::bsp {

struct SetupRow {
  uintptr_t base;
  Register row;
  uint16_t mask;
  uint16_t value;
  const char* why;
};

namespace rk3399_setup {

inline constexpr uintptr_t kGrf = 0xff77'0000, kPmuGrf = 0xff32'0000;
inline constexpr uintptr_t kCru = 0xff76'0000, kPmuCru = 0xff75'0000;

// Two bits a pin: 0 is GPIO.
constexpr Register iomux(const char* name, uint32_t offset) {
  return {name, offset, Access::kHiwordMask, 0};
}
inline constexpr Register kGPIO4A_IOMUX = iomux("GRF_GPIO4A_IOMUX", 0xe020);
inline constexpr Register kGPIO4C_IOMUX = iomux("GRF_GPIO4C_IOMUX", 0xe028);
inline constexpr Register kGPIO4D_IOMUX = iomux("GRF_GPIO4D_IOMUX", 0xe02c);
inline constexpr Register kGPIO1C_IOMUX = iomux("PMUGRF_GPIO1C_IOMUX", 0x0018);

// A gate: 1 stops the clock.
inline constexpr Register kCLKSEL_CON61 = {"CRU_CLKSEL_CON61", 0x1f4, Access::kHiwordMask, 0};
inline constexpr Register kCLKGATE_CON10 = {"CRU_CLKGATE_CON10", 0x328, Access::kHiwordMask, 0};
inline constexpr Register kCLKGATE_CON22 = {"CRU_CLKGATE_CON22", 0x358, Access::kHiwordMask, 0};
inline constexpr Register kCLKGATE_CON31 = {"CRU_CLKGATE_CON31", 0x37c, Access::kHiwordMask, 0};
inline constexpr Register kPMUCRU_CLKGATE_CON1 = {"PMUCRU_CLKGATE_CON1", 0x104, Access::kHiwordMask,
                                                  0};

}  // namespace rk3399_setup

template <size_t N>
void apply(const SetupRow (&rows)[N]) {
  for (const SetupRow& row : rows) {
    Registers(row.base).write(row.row, hiword(row.mask, row.value));
  }
}

template <size_t N>
Status holds(const SetupRow (&rows)[N], size_t& which) {
  for (which = 0; which < N; ++which) {
    const SetupRow& row = rows[which];
    if ((Registers(row.base).read(row.row) & row.mask) != row.value) return Status::kBadData;
  }
  return Status::kOk;
}

// A value outside its mask would never hold.
template <size_t N>
constexpr bool is_setup(const SetupRow (&rows)[N]) {
  for (const SetupRow& row : rows) {
    if ((row.value & ~row.mask) != 0 || row.row.access != Access::kHiwordMask) return false;
  }
  return true;
}

}  // namespace pirvs::bsp
