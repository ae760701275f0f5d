// Six cores: 0..3 are Cortex-A53, 4 and 5 are Cortex-A72. What a pose waits for runs on the A72s:
// both front-ends, then matching and tracking. The door and mapping wait for nobody.
#include "board/bare/board.h"

namespace pirvs::board {

const int kCores = 6;
const CorePlan kPlans[kPlansMax] = {
    // cores door left right tracking mapping
    {1, 0, 0, 0, 0, 0}, {2, 0, 0, 1, 0, 1}, {3, 0, 0, 1, 0, 2},
    {4, 0, 1, 2, 0, 3}, {5, 0, 4, 4, 4, 1}, {6, 0, 4, 5, 4, 1},
};

}  // namespace pirvs::board
