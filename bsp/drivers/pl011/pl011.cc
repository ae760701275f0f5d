#include "bsp/drivers/pl011/pl011.h"

#include "bsp/drivers/pl011/pl011_registers.h"

namespace pirvs::bsp {

using namespace pl011;

void Pl011::start() const {
  registers_.write(kUARTCR, 0);  // UARTLCR_H may change only while the port is off
  registers_.write(kUARTIMSC, 0);
  registers_.write(kUARTICR, kIcrAll);
  registers_.write(kUARTLCR_H, kLcrHWlen8 | kLcrHFen);
  registers_.write(kUARTCR, kCrRxe | kCrTxe | kCrUarten);
}

void Pl011::write(char c) const {
  while ((registers_.read(kUARTFR) & kFrTxff) != 0) {
  }
  registers_.write(kUARTDR, static_cast<uint8_t>(c));
}

int Pl011::read() const {
  if ((registers_.read(kUARTFR) & kFrRxfe) != 0) return -1;
  return static_cast<int>(registers_.read(kUARTDR) & 0xff);
}

}  // namespace pirvs::bsp
