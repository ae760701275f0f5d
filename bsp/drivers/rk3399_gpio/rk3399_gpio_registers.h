// One GPIO bank of the RK3399: up to 32 pins, lines A0..A7 B0..B7 C0..C7 D0..D7.
// Errors  none.
// Source  Rockchip RK3399 TRM V1.3 part 1, chapter "GPIO" (a Synopsys DesignWare APB GPIO, port A).
//         INT_POLARITY: 1 is rising or high. INTTYPE_LEVEL: 1 is edges. INTMASK: 1 is masked.
//         LS_SYNC: level interrupts pass the synchroniser. GPIO_PORTA_EOI clears latched edges.
#pragma once

#include "bsp/drivers/register.h"

namespace pirvs::bsp::rk3399_gpio {

inline constexpr Register kSWPORTA_DR = {"GPIO_SWPORTA_DR", 0x00, Access::kReadWrite, 0};
inline constexpr Register kSWPORTA_DDR = {"GPIO_SWPORTA_DDR", 0x04, Access::kReadWrite, 0};
inline constexpr Register kINTEN = {"GPIO_INTEN", 0x30, Access::kReadWrite, 0};
inline constexpr Register kINTMASK = {"GPIO_INTMASK", 0x34, Access::kReadWrite, 0};
inline constexpr Register kINTTYPE_LEVEL = {"GPIO_INTTYPE_LEVEL", 0x38, Access::kReadWrite, 0};
inline constexpr Register kINT_POLARITY = {"GPIO_INT_POLARITY", 0x3c, Access::kReadWrite, 0};
inline constexpr Register kINT_STATUS = {"GPIO_INT_STATUS", 0x40, Access::kReadOnly, 0};
inline constexpr Register kINT_RAWSTATUS = {"GPIO_INT_RAWSTATUS", 0x44, Access::kReadOnly, 0};
inline constexpr Register kDEBOUNCE = {"GPIO_DEBOUNCE", 0x48, Access::kReadWrite, 0};
inline constexpr Register kPORTA_EOI = {"GPIO_PORTA_EOI", 0x4c, Access::kWriteOnly, 0};
inline constexpr Register kEXT_PORTA = {"GPIO_EXT_PORTA", 0x50, Access::kReadOnly, 0};
inline constexpr Register kLS_SYNC = {"GPIO_LS_SYNC", 0x60, Access::kReadWrite, 0};

inline constexpr Register kRegisters[] = {
    kSWPORTA_DR, kSWPORTA_DDR,   kINTEN,    kINTMASK,   kINTTYPE_LEVEL, kINT_POLARITY,
    kINT_STATUS, kINT_RAWSTATUS, kDEBOUNCE, kPORTA_EOI, kEXT_PORTA,     kLS_SYNC,
};
static_assert(is_table(kRegisters));

}  // namespace pirvs::bsp::rk3399_gpio
