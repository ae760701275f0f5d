/* Would a branch predictor of usual size have known where a block of instructions goes on?
 *
 * Conditional branches: gshare, 4096 two-bit counters, indexed by the branch's address and the last
 * twelve outcomes. Indirect jumps and calls: the target of last time. Returns: always known.
 * What is inside the predictors of the A72 and A53 is not published; both predict at least this
 * much. In      The last instruction of each block, and the address at which the next block began.
 * Out     False: predicted wrongly.
 * Source  McFarling, "Combining Branch Predictors", 1993. */
#ifndef PIRVS_TOOLS_PROF_BRANCH_MODEL_H
#define PIRVS_TOOLS_PROF_BRANCH_MODEL_H

#include <stdbool.h>
#include <stdint.h>

enum { kHistoryBits = 12, kCounters = 1 << kHistoryBits, kTargets = 256 };

typedef enum { kStraight, kConditional, kIndirect } Branch; /* straight: nothing to predict */

typedef struct {
  uint32_t history;
  uint8_t counters[kCounters]; /* 0, 1: not taken; 2, 3: taken */
  uint64_t targets[kTargets];
} Predictor;

/* Arm ARM C4.1.66, branches. */
static inline Branch branch_of(uint32_t word) {
  const bool on_flags = (word & 0xff000010u) == 0x54000000u;
  const bool on_zero_or_bit = (word & 0x7c000000u) == 0x34000000u; /* CBZ CBNZ TBZ TBNZ */
  if (on_flags || on_zero_or_bit) return kConditional;
  const bool jump_or_call = (word & 0xffdffc1fu) == 0xd61f0000u; /* BR BLR */
  return jump_or_call ? kIndirect : kStraight;
}

static inline bool predictor_knew(Predictor* p, Branch branch, uint64_t address, uint64_t next) {
  if (branch == kStraight) return true;
  if (branch == kIndirect) {
    uint64_t* const target = &p->targets[address / 4 % kTargets];
    const bool knew = *target == next;
    *target = next;
    return knew;
  }
  const bool taken = next != address + 4;
  uint8_t* const counter = &p->counters[(address / 4 ^ p->history) % kCounters];
  const bool knew = (*counter >= 2) == taken;
  if (taken && *counter < 3) ++*counter;
  if (!taken && *counter > 0) --*counter;
  p->history = (p->history << 1 | taken) % kCounters;
  return knew;
}

#endif
