// The time of each task and of each column of the paper's Table II by this machine's own counters.
// In      profile_start() before the application runs; profile_say() when it has ended.
// Out     Lines on the console: cycles a frame, and per task its runs, mean and longest. They say
//         whether a processor counted them or an emulator, where a cycle is an instruction.
// Errors  none.
// Cost    Two readings of the counter per scope of core/trace.
// Source  PIRVS paper, Table II.
#pragma once

#include <cstdint>

namespace pirvs::board {

void profile_start();
void profile_say(uint32_t frames);

}  // namespace pirvs::board
