// Digital pins: level, direction, and edges with the time at which they came.
// In      Pin: a bank and a line, as the board's page of wiring names them.
//         gpio_watch is for set-up, before the bank's interrupt is on; one core writes pins. Each
//         watched pin has a queue of its own, polled from one core: IMU, cameras and GNSS do not
//         take each other's edges.
// Out     gpio_poll: the pin's oldest edge not yet polled. t: on the clock of now(), the first
//         thing that the interrupt handler reads. level: of the pin after the edge.
// Errors  kNotFound: no such pin. gpio_watch: kFull: kPinsWatchedMax are watched. gpio_poll:
//         kNotFound: the pin is not watched; kEmpty: nothing now; kFull: edges of this pin were
//         lost before this one, which is good.
// Cost    One or two accesses to the chip (~100 ns each); gpio_poll touches memory alone. A stamp
//         is late by the interrupt latency and never early.
// Source  DESIGN, "One way for the data": stamps are taken in the driver.
#pragma once

#include <cstdint>

#include "core/base/status.h"
#include "core/base/time.h"

namespace pirvs::bsp {

struct Pin {
  uint8_t bank = 0;
  uint8_t line = 0;

  bool operator==(Pin other) const { return bank == other.bank && line == other.line; }
};

inline constexpr int kPinsWatchedMax = 1     // IMU: data ready
                                       + 2   // cameras: exposure
                                       + 1   // GNSS: pulse per second
                                       + 4;  // robot

enum class PinDirection : uint8_t { kInput, kOutput };
enum class EdgeKind : uint8_t { kNone, kRising, kFalling, kBoth };

struct GpioEdge {
  TimeNs t = 0;
  Pin pin;
  bool level = false;
};

// The level is driven from the moment on at which the pin becomes an output.
Status gpio_direction(Pin pin, PinDirection direction, bool level = false);
Status gpio_write(Pin pin, bool level);
Result<bool> gpio_read(Pin pin);
Status gpio_watch(Pin pin, EdgeKind kind);
Status gpio_poll(Pin pin, GpioEdge& out);

}  // namespace pirvs::bsp
