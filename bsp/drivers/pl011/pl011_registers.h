// Arm PrimeCell PL011: a UART with FIFOs of 32 characters.
// Errors  none.
// Source  Arm DDI 0183, PrimeCell UART (PL011) TRM, chapter 3.
#pragma once

#include "bsp/drivers/register.h"

namespace pirvs::bsp::pl011 {

inline constexpr Register kUARTDR = {"UARTDR", 0x000, Access::kReadWrite, 0};
inline constexpr Register kUARTFR = {"UARTFR", 0x018, Access::kReadOnly, 0x90};
inline constexpr Register kUARTLCR_H = {"UARTLCR_H", 0x02c, Access::kReadWrite, 0};
inline constexpr Register kUARTCR = {"UARTCR", 0x030, Access::kReadWrite, 0x300};
inline constexpr Register kUARTIMSC = {"UARTIMSC", 0x038, Access::kReadWrite, 0};
inline constexpr Register kUARTICR = {"UARTICR", 0x044, Access::kWriteOnly, 0};

inline constexpr Register kRegisters[] = {kUARTDR, kUARTFR,   kUARTLCR_H,
                                          kUARTCR, kUARTIMSC, kUARTICR};
static_assert(is_table(kRegisters));

inline constexpr uint32_t kFrTxff = 1u << 5;  // transmit FIFO full
inline constexpr uint32_t kFrRxfe = 1u << 4;  // receive FIFO empty
inline constexpr uint32_t kLcrHWlen8 = 3u << 5;
inline constexpr uint32_t kLcrHFen = 1u << 4;  // FIFOs on
inline constexpr uint32_t kCrRxe = 1u << 9;
inline constexpr uint32_t kCrTxe = 1u << 8;
inline constexpr uint32_t kCrUarten = 1u << 0;
inline constexpr uint32_t kIcrAll = 0x7ff;

}  // namespace pirvs::bsp::pl011
