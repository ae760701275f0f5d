// Serial lines (UART), 8 data bits, no parity, 1 stop bit: to a robot or a GNSS receiver. Text for
// a person goes to bsp/api/console.h.
// In      A port as the board numbers them; bytes.
// Out     serial_write: how many of the bytes the chip took, from the first; the caller offers the
//         rest again. serial_read: at least one byte, at most `max`.
// Errors  serial_open: kNotFound (no such port), kBadData (the clock cannot make this rate within 2
//         %), kTimeout (the line never falls silent). serial_read: kEmpty: nothing now; kFull:
//         bytes were lost on the way here; kBadData: one arrived damaged and was dropped. `count`
//         is valid after the last two as well.
// Cost    ~100 ns a byte. Never waits, but for serial_open: up to 20 ms.
// Source  STYLE principle 3.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/status.h"

namespace pirvs::bsp {

Status serial_open(int port, uint32_t baud);
size_t serial_write(int port, const uint8_t* data, size_t size);
Status serial_read(int port, uint8_t* data, size_t max, size_t& count);

}  // namespace pirvs::bsp
