// Any PC: three threads where its kernel puts them; sensors and tracking before other programs,
// behind the kernel's threads for interrupts (50).
#include "board/linux/board.h"
#include "board/pc/jpeg.h"
#include "bsp/drivers/icm20602/icm20602.h"

namespace pirvs::board {

constexpr LinuxBoard kBoard = {
    "pc",
    // cores door left right tracking mapping, frames a second
    {3, 0, 0, 1, 0, 2, 60},
    {{-1, 40}, {-1, 39}, {-1, 0}, {-1, 0}, {}, {}},
    nullptr,
    jpeg_to_grey,
};
static_assert(keeps_up(kBoard.plan, bsp::Icm20602::kFifo), "budgets are an A72's: a PC is faster");

}  // namespace pirvs::board
