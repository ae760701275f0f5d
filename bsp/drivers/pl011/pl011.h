// Driver of Arm's PL011 serial port, by polling: a console.
// In      The chip's base address. 8 bits, no parity, one stop bit, at the rate the firmware set.
// Out     start: FIFOs on, transmitter and receiver on, interrupts off. write waits while the FIFO
//         is full. read: the oldest character, or -1.
// Errors  none: characters that arrive while the FIFO is full are lost.
// Cost    write: two accesses, or the time of a character on the line.
// Source  pl011_registers.h.
#pragma once

#include "bsp/drivers/register.h"

namespace pirvs::bsp {

class Pl011 {
 public:
  constexpr explicit Pl011(uintptr_t base) : registers_(base) {}

  void start() const;
  void write(char c) const;
  int read() const;

 private:
  Registers registers_;
};

}  // namespace pirvs::bsp
