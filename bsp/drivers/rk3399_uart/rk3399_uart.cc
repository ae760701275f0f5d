#include "bsp/drivers/rk3399_uart/rk3399_uart.h"

#include "bsp/api/clock.h"
#include "bsp/drivers/rk3399_uart/rk3399_uart_registers.h"
#include "core/base/time.h"

namespace pirvs::bsp {

using namespace rk3399_uart;

namespace {

constexpr TimeNs kSilence_ns = 20'000'000;  // a full FIFO leaves at 57600 baud in 11 ms

// The divisor of 16 times the rate, 0 if none comes within 2 %.
constexpr uint32_t divisor_of(uint32_t clock_hz, uint32_t baud) {
  if (baud == 0 || baud > clock_hz / 8) return 0;
  const uint32_t divisor = (clock_hz / 8 / baud + 1) / 2;
  const int64_t error_hz = int64_t{clock_hz} / 16 / divisor - baud;
  const bool close = error_hz * 50 <= baud && -error_hz * 50 <= baud;
  return close && divisor <= 0xffff ? divisor : 0;
}
static_assert(divisor_of(24'000'000, 1'500'000) == 1);
static_assert(divisor_of(24'000'000, 115'200) == 13);
static_assert(divisor_of(24'000'000, 1'000'000) == 0);

}  // namespace

Status Rk3399Uart::open(uint32_t baud) const {
  const uint32_t divisor = divisor_of(clock_hz_, baud);
  if (divisor == 0) return Status::kBadData;
  registers_.write(kIER_DLH, 0);
  const TimeNs deadline = now() + kSilence_ns;
  for (;;) {
    const bool late = now() > deadline;
    // A byte on the line between the two accesses makes the chip ignore the second: look whether
    // it was taken.
    if ((registers_.read(kUSR) & kUsrBusy) == 0) {
      registers_.write(kLCR, kLcrDivisor | kLcrEightBits);
      if (registers_.read(kLCR) == (kLcrDivisor | kLcrEightBits)) break;
    }
    if (late) return Status::kTimeout;
  }
  registers_.write(kRBR_THR_DLL, divisor & 0xff);
  registers_.write(kIER_DLH, divisor >> 8);
  registers_.write(kLCR, kLcrEightBits);
  registers_.write(kIIR_FCR, kFcrEnable | kFcrResetRx | kFcrResetTx);
  registers_.write(kMCR, 0);
  return registers_.read(kLCR) == kLcrEightBits ? Status::kOk : Status::kTimeout;
}

size_t Rk3399Uart::write(const uint8_t* data, size_t size) const {
  size_t taken = 0;
  while (taken < size && (registers_.read(kUSR) & kUsrTxNotFull) != 0) {
    registers_.write(kRBR_THR_DLL, data[taken++]);
  }
  return taken;
}

Status Rk3399Uart::read(uint8_t* data, size_t max, size_t& count) const {
  count = 0;
  bool lost = false, damaged = false, nothing = false;
  while (count < max && !nothing) {
    const uint32_t line = registers_.read(kLSR);  // reading clears its errors
    lost |= (line & kLsrOverrun) != 0;
    nothing = (line & kLsrDataReady) == 0;
    if (nothing) break;
    const uint8_t byte = static_cast<uint8_t>(registers_.read(kRBR_THR_DLL));
    const bool good = (line & (kLsrParity | kLsrFraming | kLsrBreak)) == 0;
    damaged |= !good;
    if (good) data[count++] = byte;
  }
  if (lost) return Status::kFull;
  if (damaged) return Status::kBadData;
  return count > 0 ? Status::kOk : Status::kEmpty;
}

void Rk3399Uart::put(uint8_t byte) const {
  while (write(&byte, 1) == 0) {
  }
}

}  // namespace pirvs::bsp
