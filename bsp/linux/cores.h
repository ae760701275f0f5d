// Where and how urgently a core of bsp/api/cores.h runs on Linux.
// In      set_core: before start_core; core 0 is the calling thread, at once. cpu -1: anywhere.
//         priority 0: as any program; 1 to 99: SCHED_FIFO.
//         leave_cores: the calling thread serves none of them: it goes where no core keeps it off,
//         as urgent as any program, whatever it inherited.
//         ask_not_to_be_killed: other programs go first when memory runs out, where the process has
//         the right to say so.
// Out     core_refusals(): the first thing that the kernel did not permit, nullptr: it permitted
//         all. The core runs all the same.
// Errors  as said; a missing right is CAP_SYS_NICE or RLIMIT_RTPRIO, a missing CPU the machine's.
// Cost    Two system calls as the core starts.
// Source  sched(7), pthread_setaffinity_np(3).
#pragma once

namespace pirvs::bsp {

struct CoreSetup {
  int cpu = -1;
  int priority = 0;
};

void set_core(int core, const CoreSetup& setup);
void leave_cores();
void ask_not_to_be_killed();
const char* core_refusals();

}  // namespace pirvs::bsp
