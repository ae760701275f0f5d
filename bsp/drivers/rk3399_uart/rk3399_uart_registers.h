// A UART of the RK3399: a 16550 whose registers are 4 bytes apart, with FIFOs of 64 bytes.
// Errors  none.
// Source  Rockchip RK3399 TRM V1.3 part 2, chapter "UART" (a Synopsys DesignWare APB UART). Three
//         offsets hold several registers: which one answers depends on the direction of the access
//         and on LCR.DLAB. While USR.BUSY is set, a write to LCR or to the divisor is ignored.
#pragma once

#include "bsp/drivers/register.h"

namespace pirvs::bsp::rk3399_uart {

inline constexpr Register kRBR_THR_DLL = {"UART_RBR/THR/DLL", 0x00, Access::kReadWrite, 0};
inline constexpr Register kIER_DLH = {"UART_IER/DLH", 0x04, Access::kReadWrite, 0};
inline constexpr Register kIIR_FCR = {"UART_IIR/FCR", 0x08, Access::kReadWrite, 1};
inline constexpr Register kLCR = {"UART_LCR", 0x0c, Access::kReadWrite, 0};
inline constexpr Register kMCR = {"UART_MCR", 0x10, Access::kReadWrite, 0};
inline constexpr Register kLSR = {"UART_LSR", 0x14, Access::kReadOnly, 0x60};
inline constexpr Register kUSR = {"UART_USR", 0x7c, Access::kReadOnly, 0x06};
inline constexpr Register kTFL = {"UART_TFL", 0x80, Access::kReadOnly, 0};
inline constexpr Register kRFL = {"UART_RFL", 0x84, Access::kReadOnly, 0};

inline constexpr Register kRegisters[] = {
    kRBR_THR_DLL, kIER_DLH, kIIR_FCR, kLCR, kMCR, kLSR, kUSR, kTFL, kRFL,
};
static_assert(is_table(kRegisters));

inline constexpr uint32_t kFifoBytes = 64;

inline constexpr uint32_t kFcrEnable = 1u << 0, kFcrResetRx = 1u << 1, kFcrResetTx = 1u << 2;
inline constexpr uint32_t kLcrEightBits = 3u << 0, kLcrDivisor = 1u << 7;  // DLS, DLAB
inline constexpr uint32_t kLsrDataReady = 1u << 0, kLsrOverrun = 1u << 1, kLsrParity = 1u << 2,
                          kLsrFraming = 1u << 3, kLsrBreak = 1u << 4;
inline constexpr uint32_t kUsrBusy = 1u << 0, kUsrTxNotFull = 1u << 1;

}  // namespace pirvs::bsp::rk3399_uart
