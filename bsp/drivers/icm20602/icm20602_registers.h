// TDK InvenSense ICM-20602: gyroscope and accelerometer with a FIFO, registers of a byte.
// Errors  none.
// Source  DS-000176 (ICM-20602 data sheet), register map.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::bsp::icm20602 {

inline constexpr uint8_t kSMPLRT_DIV = 0x19, kCONFIG = 0x1a, kGYRO_CONFIG = 0x1b,
                         kACCEL_CONFIG = 0x1c, kACCEL_CONFIG2 = 0x1d, kFIFO_EN = 0x23,
                         kINT_PIN_CFG = 0x37, kINT_ENABLE = 0x38, kUSER_CTRL = 0x6a,
                         kPWR_MGMT_1 = 0x6b, kPWR_MGMT_2 = 0x6c, kFIFO_COUNTH = 0x72,
                         kFIFO_COUNTL = 0x73, kFIFO_R_W = 0x74, kWHO_AM_I = 0x75;

inline constexpr uint8_t kIdentity = 0x12;
inline constexpr uint8_t kDeviceReset = 1 << 7;                      // PWR_MGMT_1
inline constexpr uint8_t kFifoEnable = 1 << 6, kFifoReset = 1 << 2;  // USER_CTRL
inline constexpr uint8_t kPwrMgmt1AfterReset = 0x41;                 // asleep

struct SetupByte {
  uint8_t address;
  uint8_t value;
  const char* why;
};

// In this order after a reset; read back one by one while the chip runs, to see a reset.
inline constexpr SetupByte kSetup[] = {
    {kPWR_MGMT_1, 0x01, "awake, clock from the gyroscope's PLL"},
    {kPWR_MGMT_2, 0x00, "all six axes"},
    {kCONFIG, 0x43, "FIFO stops when full, so that packets stay whole; gyroscope 41 Hz"},
    {kSMPLRT_DIV, 4, "1 kHz / 5 = 200 Hz"},
    {kGYRO_CONFIG, 0x18, "+-2000 deg/s"},
    {kACCEL_CONFIG, 0x10, "+-8 g"},
    {kACCEL_CONFIG2, 0x03, "accelerometer 45 Hz"},
    {kINT_PIN_CFG, 0x00, "a pulse of 50 us, active high"},
    {kINT_ENABLE, 0x01, "one for each sample"},
    {kFIFO_EN, 0x18, "accelerometer, temperature and gyroscope: 14 bytes a sample"},
};
inline constexpr size_t kSetupRows = sizeof kSetup / sizeof kSetup[0];

inline constexpr size_t kPacketBytes = 14;
inline constexpr size_t kFifoBytes = 1008;
static_assert(kFifoBytes % kPacketBytes == 0);

}  // namespace pirvs::bsp::icm20602
