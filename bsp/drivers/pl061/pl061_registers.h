// Arm PrimeCell PL061: eight pins, edges latched in the chip.
// Errors  none.
// Source  Arm DDI 0190B, PrimeCell GPIO (PL061) TRM, chapter 3. GPIODATA is 256 words: bits 9..2 of
//         the address say which pins an access reads or writes; all others keep their level.
#pragma once

#include "bsp/drivers/register.h"

namespace pirvs::bsp::pl061 {

inline constexpr Register kGPIODATA = {"GPIODATA", 0x000, Access::kReadWrite, 0};
inline constexpr Register kGPIODIR = {"GPIODIR", 0x400, Access::kReadWrite, 0};
inline constexpr Register kGPIOIS = {"GPIOIS", 0x404, Access::kReadWrite, 0};
inline constexpr Register kGPIOIBE = {"GPIOIBE", 0x408, Access::kReadWrite, 0};
inline constexpr Register kGPIOIEV = {"GPIOIEV", 0x40c, Access::kReadWrite, 0};
inline constexpr Register kGPIOIE = {"GPIOIE", 0x410, Access::kReadWrite, 0};
inline constexpr Register kGPIORIS = {"GPIORIS", 0x414, Access::kReadOnly, 0};
inline constexpr Register kGPIOMIS = {"GPIOMIS", 0x418, Access::kReadOnly, 0};
inline constexpr Register kGPIOIC = {"GPIOIC", 0x41c, Access::kWriteOnly, 0};
inline constexpr Register kGPIOAFSEL = {"GPIOAFSEL", 0x420, Access::kReadWrite, 0};

inline constexpr Register kRegisters[] = {
    kGPIODATA, kGPIODIR, kGPIOIS,  kGPIOIBE, kGPIOIEV,
    kGPIOIE,   kGPIORIS, kGPIOMIS, kGPIOIC,  kGPIOAFSEL,
};
static_assert(is_table(kRegisters));

}  // namespace pirvs::bsp::pl061
