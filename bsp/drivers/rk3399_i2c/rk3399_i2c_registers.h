// An I2C controller of the RK3399: it runs a whole message of up to 32 bytes by itself.
// Errors  none.
// Source  Rockchip RK3399 TRM V1.3 part 2, chapter "I2C". RKI2C_IPD: a 1 written clears.
//         SCL = clock / (8 (CLKDIVL + 1 + CLKDIVH + 1)). A read raises a START interrupt that means
//         nothing; register-read mode (3) also writes the register's address and is not used.
#pragma once

#include "bsp/drivers/register.h"

namespace pirvs::bsp::rk3399_i2c {

inline constexpr Register kCON = {"RKI2C_CON", 0x000, Access::kReadWrite, 0};
inline constexpr Register kCLKDIV = {"RKI2C_CLKDIV", 0x004, Access::kReadWrite, 0x00060006};
inline constexpr Register kMRXADDR = {"RKI2C_MRXADDR", 0x008, Access::kReadWrite, 0};
inline constexpr Register kMRXRADDR = {"RKI2C_MRXRADDR", 0x00c, Access::kReadWrite, 0};
inline constexpr Register kMTXCNT = {"RKI2C_MTXCNT", 0x010, Access::kReadWrite, 0};
inline constexpr Register kMRXCNT = {"RKI2C_MRXCNT", 0x014, Access::kReadWrite, 0};
inline constexpr Register kIEN = {"RKI2C_IEN", 0x018, Access::kReadWrite, 0};
inline constexpr Register kIPD = {"RKI2C_IPD", 0x01c, Access::kClearByOne, 0};
inline constexpr Register kFCNT = {"RKI2C_FCNT", 0x020, Access::kReadOnly, 0};
inline constexpr Register kTXDATA0 = {"RKI2C_TXDATA0", 0x100, Access::kReadWrite, 0};  // .. 7
inline constexpr Register kRXDATA0 = {"RKI2C_RXDATA0", 0x200, Access::kReadOnly, 0};   // .. 7

inline constexpr Register kRegisters[] = {
    kCON, kCLKDIV, kMRXADDR, kMRXRADDR, kMTXCNT, kMRXCNT, kIEN, kIPD, kFCNT, kTXDATA0, kRXDATA0,
};
static_assert(is_table(kRegisters));

inline constexpr uint32_t kMessageBytes = 32;
inline constexpr uint32_t kDataWords = kMessageBytes / 4;

inline constexpr uint32_t kConEnable = 1u << 0, kConStart = 1u << 3, kConStop = 1u << 4,
                          kConLastNack = 1u << 5,  // refuse a byte after the last one received
    kConNackStops = 1u << 6;                       // end the message when a byte is refused
inline constexpr uint32_t kConModeMask = 3u << 1, kConModeTx = 0u << 1, kConModeAddressRx = 1u << 1,
                          kConModeRx = 2u << 1;
inline constexpr uint32_t kIpdTxDone = 1u << 2, kIpdRxDone = 1u << 3, kIpdStart = 1u << 4,
                          kIpdStop = 1u << 5, kIpdNack = 1u << 6, kIpdAll = 0x7f;

// The bit of MRXADDR and MRXRADDR that says that byte `i` counts.
constexpr uint32_t address_valid(uint32_t i) { return 1u << (24 + i); }

}  // namespace pirvs::bsp::rk3399_i2c
