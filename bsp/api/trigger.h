// Pulses that start the exposure of cameras, made by hardware so that they do not jitter.
// In      An output as the board numbers them; period, width and phase of its pulses: the first one
//         begins when now() is `phase_ns` past a multiple of the period.
// Out     trigger_start: when the first pulse began, on the clock of now(), and the period that the
//         hardware really keeps (it counts ticks of its own clock): pulse k begins at first_t + k *
//         period_ns, known to error_ns. trigger_stop leaves the output inactive.
// Errors  kNotFound: no such output. kBadData: width or phase not below the period, or a pulse
//         shorter than a tick. kTimeout: hardware whose start can be timed could not be timed to
//         kTriggerError in three tries (interrupted each time); the output is inactive. kBusFault:
//         the operating system refuses.
// Cost    trigger_start waits for the phase, up to three periods: for set-up. The rest, two
//         accesses.
// Source  DESIGN, "One way for the data": a frame's stamp is that of its trigger.
#pragma once

#include <cstdint>

#include "core/base/status.h"
#include "core/base/time.h"

namespace pirvs::bsp {

inline constexpr TimeNs kTriggerError = 5'000;

struct TriggerTiming {
  uint32_t period_ns = 0;
  uint32_t width_ns = 0;
  uint32_t phase_ns = 0;
  bool active_low = false;
};

struct TriggerStart {
  TimeNs first_t = 0;
  double period_ns = 0.0;
  TimeNs error_ns = kTriggerError;
};

Result<TriggerStart> trigger_start(int output, const TriggerTiming& timing);
Status trigger_stop(int output);

}  // namespace pirvs::bsp
