// Six cores: 0..3 are Cortex-A53, 4 and 5 are Cortex-A72. What a pose waits for runs on the A72s:
// both front-ends, then matching and tracking. The door and mapping wait for nobody.
#include "board/bare/board.h"
#include "bsp/drivers/icm20602/icm20602.h"

namespace pirvs::board {

const int kCores = 6;
constexpr uint8_t kA53s = 0b00'1111;
constexpr CorePlan kPlans[kPlansMax] = {
    // cores door left right tracking mapping, frames a second
    {1, 0, 0, 0, 0, 0, 10, kA53s}, {2, 0, 0, 1, 0, 1, 15, kA53s}, {3, 0, 0, 1, 0, 2, 15, kA53s},
    {4, 0, 1, 2, 0, 3, 30, kA53s}, {5, 0, 4, 4, 4, 1, 50, kA53s}, {6, 0, 4, 5, 4, 1, 60, kA53s},
};
static_assert(keep_up(kPlans, bsp::Icm20602::kFifo));

}  // namespace pirvs::board
