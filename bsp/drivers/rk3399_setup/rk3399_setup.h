// Set-up of the RK3399 around its controllers, as data: which function a pin has, which clocks run.
// In      Rows: a register of GRF, PMUGRF, CRU or PMUCRU, the bits that matter, their value, why.
// Out     apply: writes them in order. holds: reads them back, so that a reset or another master's
//         change is seen. gpll_hz, pmu_pclk_hz: what the boot loader has made of two clocks.
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
constexpr Register hiword_register(const char* name, uint32_t offset) {
  return {name, offset, Access::kHiwordMask, 0};
}
inline constexpr Register kGPIO2A_IOMUX = hiword_register("GRF_GPIO2A_IOMUX", 0xe000);
inline constexpr Register kGPIO2B_IOMUX = hiword_register("GRF_GPIO2B_IOMUX", 0xe004);
inline constexpr Register kGPIO4C_IOMUX = hiword_register("GRF_GPIO4C_IOMUX", 0xe028);
inline constexpr Register kGPIO4D_IOMUX = hiword_register("GRF_GPIO4D_IOMUX", 0xe02c);

// A gate: 1 stops the clock.
inline constexpr Register kGPLL_CON0 = {"CRU_GPLL_CON0", 0x080, Access::kReadWrite, 0};
inline constexpr Register kGPLL_CON1 = {"CRU_GPLL_CON1", 0x084, Access::kReadWrite, 0};
inline constexpr Register kCLKSEL_CON63 = hiword_register("CRU_CLKSEL_CON63", 0x1fc);
inline constexpr Register kCLKGATE_CON10 = hiword_register("CRU_CLKGATE_CON10", 0x328);
inline constexpr Register kCLKGATE_CON22 = hiword_register("CRU_CLKGATE_CON22", 0x358);
inline constexpr Register kCLKGATE_CON31 = hiword_register("CRU_CLKGATE_CON31", 0x37c);

inline constexpr Register kPPLL_CON0 = {"PMUCRU_PPLL_CON0", 0x000, Access::kReadWrite, 0};
inline constexpr Register kPPLL_CON1 = {"PMUCRU_PPLL_CON1", 0x004, Access::kReadWrite, 0};
inline constexpr Register kPMU_CLKSEL_CON0 = hiword_register("PMUCRU_CLKSEL_CON0", 0x080);
inline constexpr Register kPMU_CLKGATE_CON1 = hiword_register("PMUCRU_CLKGATE_CON1", 0x104);

inline constexpr uint64_t kCrystal_hz = 24'000'000;

// FBDIV; POSTDIV2, POSTDIV1, REFDIV. 0 if a divider is 0.
constexpr uint32_t pll_hz(uint32_t con0, uint32_t con1) {
  const uint32_t divider = (con1 & 0x3f) * (con1 >> 8 & 7) * (con1 >> 12 & 7);
  return divider == 0 ? 0 : static_cast<uint32_t>(kCrystal_hz * (con0 & 0xfff) / divider);
}
static_assert(pll_hz(99, 2 << 12 | 2 << 8 | 1) == 594'000'000);

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

inline uint32_t gpll_hz() {
  const Registers cru(rk3399_setup::kCru);
  return rk3399_setup::pll_hz(cru.read(rk3399_setup::kGPLL_CON0),
                              cru.read(rk3399_setup::kGPLL_CON1));
}

// PPLL by PMU_PCLK_DIV_CON + 1: it drives the PWM.
inline uint32_t pmu_pclk_hz() {
  const Registers pmucru(rk3399_setup::kPmuCru);
  const uint32_t ppll_hz = rk3399_setup::pll_hz(pmucru.read(rk3399_setup::kPPLL_CON0),
                                                pmucru.read(rk3399_setup::kPPLL_CON1));
  return ppll_hz / ((pmucru.read(rk3399_setup::kPMU_CLKSEL_CON0) & 0x1f) + 1);
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
