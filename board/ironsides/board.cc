// RK3399: CPUs 0 to 3 are Cortex-A53, 4 and 5 Cortex-A72. Door, tracking and the left front-end
// share an A72, the right front-end has the other; mapping is background beside it: it may take
// longer than a frame, and waits while the front-end runs. The recorder writes from an A53.
// Priorities lie below 50, where the kernel's threads for interrupts run.
#include <linux/media-bus-format.h>

#include <iterator>

#include "board/linux/board.h"
#include "bsp/drivers/icm20602/icm20602.h"

namespace pirvs::board {

// Both ISPs of Linux 6.1's rkisp1; from 6.0 on the receiver is a stage of its own.
constexpr uint8_t kSink = bsp::MediaStage::kSink, kSource = bsp::MediaStage::kSource;
constexpr uint32_t kYuv = MEDIA_BUS_FMT_YUYV8_2X8;  // grey leaves as its luma
constexpr bsp::MediaStage kIspStages[] = {
    // entity, sink, source, code, optional, crops, full range
    {"rkisp1_csi", 0, 1, 0, true},
    {"rkisp1_isp", 0, 2, kYuv, false, kSink | kSource, true},
    {"rkisp1_resizer_mainpath", 0, 1, kYuv, false, kSink},
};
constexpr bsp::MediaTable kIsps = {"rkisp1",          {"isp0@ff910000", "isp1@ff920000"},
                                   kIspStages,        static_cast<int>(std::size(kIspStages)),
                                   "rkisp1_mainpath", "rkisp1_isp"};

constexpr LinuxBoard kBoard = {
    "ironsides",
    // cores door left right tracking mapping, frames a second
    {3, 0, 0, 1, 0, 2, 60},
    {{4, 40}, {5, 39}, {5, 0}, {3, 0}, {}, {}},
    &kIsps,
};
static_assert(keeps_up(kBoard.plan, bsp::Icm20602::kFifo));

}  // namespace pirvs::board
