// An I2C bus of Linux, /dev/i2c-N: what bsp/api/i2c.h means by transfer.
// In      The bus's number; a transfer, which is done when transfer() returns.
// Errors  As bsp/api/i2c.h; kNotFound: no such bus, or no right to use it.
// Cost    A system call that sleeps while the bus works: 32 bytes at 400 kHz, 0.8 ms.
// Source  kernel, Documentation/i2c/dev-interface.rst, I2C_RDWR.
#pragma once

#include "bsp/api/i2c.h"
#include "bsp/linux/system_calls.h"

namespace pirvs::bsp {

class I2cDev {
 public:
  ~I2cDev() { close(); }
  Status transfer(int bus, const I2cTransfer& transfer, const SystemCalls& calls = kSystemCalls);
  void close();

 private:
  const SystemCalls* calls_ = &kSystemCalls;
  int fd_ = -1;
  int bus_ = -1;
};

}  // namespace pirvs::bsp
