// Four equal cores.
#include "board/bare/board.h"
#include "bsp/drivers/icm20602/icm20602.h"

namespace pirvs::board {

const int kCores = 4;
constexpr CorePlan kPlans[kPlansMax] = {
    // cores door left right tracking mapping, frames a second
    {1, 0, 0, 0, 0, 0, 40},
    {2, 0, 0, 1, 0, 1, 60},
    {3, 0, 0, 1, 0, 2, 60},
    {4, 0, 1, 2, 0, 3, 60},
};
static_assert(keep_up(kPlans, bsp::Icm20602::kFifo));

}  // namespace pirvs::board
