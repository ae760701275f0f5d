// I2C bus, master, 7-bit addresses: write, read, or write a register's address and read from there.
// In      i2c_start: one transfer at a time per bus; its buffers stay valid until it ends. Up to
//         kI2cWriteMax bytes before a read (a register's address), any number otherwise.
// Out     i2c_poll: kEmpty while the transfer runs; the same call carries it on, so ask often
//         (at 400 kHz, 32 bytes take 0.8 ms). kOk: done, all bytes are in place.
//         i2c_transfer: both, waiting. For set-up; never from a timed step.
// Errors  i2c_start: kNotFound (no such bus), kFull (one runs already), kBadData (too many bytes
//         before a read, or nothing to do). i2c_poll: kBusFault: no chip answered at the address,
//         or it refused a byte; kTimeout: not finished kI2cTimeout after the start, the bus is
//         held: the controller was reset. kStale: nothing was started.
// Cost    A poll: one to nine accesses to the controller.
// Source  NXP UM10204, I2C-bus specification.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/status.h"
#include "core/base/time.h"

namespace pirvs::bsp {

inline constexpr size_t kI2cWriteMax = 3;
inline constexpr TimeNs kI2cTimeout = 50'000'000;

struct I2cTransfer {
  uint8_t address = 0;
  const uint8_t* out = nullptr;
  size_t out_size = 0;
  uint8_t* in = nullptr;
  size_t in_size = 0;
};

Status i2c_start(int bus, const I2cTransfer& transfer);
Status i2c_poll(int bus);

inline Status i2c_transfer(int bus, const I2cTransfer& transfer) {
  PIRVS_TRY(i2c_start(bus, transfer));
  Status status = Status::kEmpty;
  while (status == Status::kEmpty) status = i2c_poll(bus);
  return status;
}

}  // namespace pirvs::bsp
