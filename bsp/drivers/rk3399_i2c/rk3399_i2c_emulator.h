// An emulated I2C controller of the RK3399 with one chip on its bus, for tests of drivers.
// In      The driver's accesses; a device with start, write and read of emulated/i2c_device.h.
// Out     What the bus carried, in the device; scl_hz(): the rate that the divisor gives.
// Errors  See emulated/register_file.h; a message longer than 32 bytes, or without a start before
//         it: a bug of the driver, asserts. hold_bus: a chip holds SCL, nothing ever ends.
// Cost    Each event shows in RKI2C_IPD one read late, so that a driver must wait for it.
// Source  rk3399_i2c_registers.h.
#pragma once

#include <cstdint>

#include "bsp/drivers/emulated/i2c_device.h"
#include "bsp/drivers/emulated/register_file.h"
#include "bsp/drivers/rk3399_i2c/rk3399_i2c_registers.h"

namespace pirvs::bsp::emulated {

class Rk3399I2cChip {
 public:
  static constexpr uint32_t kSize = 0x300;

  explicit Rk3399I2cChip(I2cDevice& device) : device_(device) {}

  uint32_t read(uint32_t offset);
  void write(uint32_t offset, uint32_t value);
  void hold_bus(bool held) { held_ = held; }
  uint32_t scl_hz(uint32_t clock_hz) const;

 private:
  void control(uint32_t before, uint32_t value);
  bool put(uint8_t byte);
  void transmit(uint32_t count);
  void receive(uint32_t count);
  void raise(uint32_t events);

  I2cDevice& device_;
  RegisterFile file_{rk3399_i2c::kRegisters};
  uint32_t tx_[rk3399_i2c::kDataWords] = {};
  uint32_t rx_[rk3399_i2c::kDataWords] = {};
  uint32_t coming_ = 0;     // events that the next read of IPD does not show yet
  bool started_ = false;    // a START is on the bus, no STOP yet
  bool addressed_ = false;  // the device answered since
  bool held_ = false;
};

}  // namespace pirvs::bsp::emulated
