// How time passes, for whoever judges that a sensor has fallen silent: a source like the sensors,
// so that a recording of a run holds it, too.
// In      Poll beside the sensors.
// Out     now(), once for each kTick_ns that have passed since the tick before; late ones are left
//         out. A replay as fast as possible has no time of its own: it gives the recorded ticks, or
//         none.
// Errors  kEmpty: no tick is due.
// Cost    A reading of the clock.
// Source  docs/architecture.md, "One way for the data".
#pragma once

#include "core/base/status.h"
#include "core/base/time.h"

namespace pirvs::bsp {

inline constexpr TimeNs kTick_ns = 10'000'000;

Status tick_poll(TimeNs& out);

}  // namespace pirvs::bsp
