// Four equal cores.
#include "board/bare/board.h"

namespace pirvs::board {

const int kCores = 4;
const CorePlan kPlans[kPlansMax] = {
    // cores door left right tracking mapping
    {1, 0, 0, 0, 0, 0},
    {2, 0, 0, 1, 0, 1},
    {3, 0, 0, 1, 0, 2},
    {4, 0, 1, 2, 0, 3},
};

}  // namespace pirvs::board
