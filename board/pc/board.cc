// Any PC: three threads where its kernel puts them; sensors and tracking before other programs,
// behind the kernel's threads for interrupts (50).
#include "board/linux/board.h"

namespace pirvs::board {

extern const LinuxBoard kBoard;
const LinuxBoard kBoard = {
    "pc",
    // cores door left right tracking mapping
    {3, 0, 0, 1, 0, 2},
    {{-1, 40}, {-1, 39}, {-1, 0}, {-1, 0}, {}, {}},
};

}  // namespace pirvs::board
