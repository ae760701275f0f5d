// What    a board without an operating system adds to its machine (bsp/bare/machine.h): who runs
// where. Defined in board/<name>/board.cc; board/bare/main.cc runs the application on it.
// In, Out constants.
// Errors  Asserted there: every core that a plan names exists.
// Source  DESIGN, "board/<name>".
#pragma once

#include "modules/app/app.h"

namespace pirvs::board {

inline constexpr int kPlansMax = 6;

// kPlans[n - 1] spreads the tasks over n cores; the last one is the board's own.
extern const CorePlan kPlans[kPlansMax];
extern const int kCores;

}  // namespace pirvs::board
