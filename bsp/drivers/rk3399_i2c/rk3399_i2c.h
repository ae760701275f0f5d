// Driver of one I2C controller of the RK3399. Its pins and clock must be on
// (bsp/drivers/rk3399_setup).
// In      The controller's base address and the rate of its clock; the time with each call.
// Out     bsp/api/i2c.h for this bus. open: the rate of SCL, at most `scl_hz`.
// Errors  As bsp/api/i2c.h; open: kBadData: no divisor gives the rate.
// Cost    A poll: one access while nothing has come; with a full message, up to ten.
// Source  rk3399_i2c_registers.h. Low and high share the period 3 to 2: at 400 kHz, low 1.5 us and
//         high 1.0 us, edges included (the bus asks for 1.3 and 0.6, UM10204 table 10).
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/api/i2c.h"
#include "bsp/drivers/register.h"
#include "core/base/status.h"
#include "core/base/time.h"

namespace pirvs::bsp {

class Rk3399I2c {
 public:
  constexpr Rk3399I2c(uintptr_t base, uint32_t clock_hz) : registers_(base), clock_hz_(clock_hz) {}

  Status open(uint32_t scl_hz);
  Status start(const I2cTransfer& transfer, TimeNs now);
  Status poll(TimeNs now);

 private:
  enum class Stage : uint8_t { kIdle, kStarting, kWriting, kReading, kStopping };

  bool reads() const { return transfer_.in_size > 0; }
  Status end(Status status);
  void stop(Status status);
  void begin_data();
  void write_message();
  void ask_for_message();
  void take_message();

  Registers registers_;
  uint32_t clock_hz_;
  I2cTransfer transfer_;
  Stage stage_ = Stage::kIdle;
  Status outcome_ = Status::kOk;  // what to say once the bus has stopped
  size_t done_ = 0;               // bytes written or read so far
  TimeNs deadline_ = 0;
};

}  // namespace pirvs::bsp
