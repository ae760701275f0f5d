// RK3399: CPUs 0 to 3 are Cortex-A53, 4 and 5 Cortex-A72. Door, tracking and the left front-end
// share an A72, the right front-end has the other; mapping is background beside it: it may take
// longer than a frame, and waits while the front-end runs. The recorder writes from an A53.
// Priorities lie below 50, where the kernel's threads for interrupts run.
#include "board/linux/board.h"
#include "bsp/drivers/icm20602/icm20602.h"

namespace pirvs::board {

constexpr LinuxBoard kBoard = {
    "ironsides",
    // cores door left right tracking mapping, frames a second
    {3, 0, 0, 1, 0, 2, 60},
    {{4, 40}, {5, 39}, {5, 0}, {3, 0}, {}, {}},
};
static_assert(keeps_up(kBoard.plan, bsp::Icm20602::kFifo));

}  // namespace pirvs::board
