#include "bsp/bare/interrupts.h"

#include "bsp/bare/machine.h"
#include "bsp/bare/registers.h"
#include "bsp/drivers/gicv3/gicv3.h"
#include "core/base/assert.h"

namespace pirvs::bsp {
namespace {

constexpr int kHandlersMax = 16;
constexpr uint32_t kNoInterrupt = 1020;  // and up: spurious
constexpr uint32_t kMessagesMax = 16;    // INTIDs of messages between cores
constexpr uint64_t kEveryPriority = 0xff;
constexpr uint64_t kToAllOthers = uint64_t{1} << 40;  // ICC_SGI1R_EL1.IRM

struct {
  uint32_t intid;
  InterruptHandler handler;
} handlers[kHandlersMax];
int handlers_size = 0;

// ICC_* have no names in binutils before GICv3 is switched on by -march; these are their encodings.
#define PIRVS_ICC_PMR_EL1 S3_0_C4_C6_0
#define PIRVS_ICC_IAR1_EL1 S3_0_C12_C12_0
#define PIRVS_ICC_EOIR1_EL1 S3_0_C12_C12_1
#define PIRVS_ICC_SGI1R_EL1 S3_0_C12_C11_5
#define PIRVS_ICC_SRE_EL1 S3_0_C12_C12_5
#define PIRVS_ICC_IGRPEN1_EL1 S3_0_C12_C12_7
// The macros of registers.h put a name into quotes before it is replaced.
#define PIRVS_READ_BY(name) PIRVS_READ(name)
#define PIRVS_WRITE_BY(name, value) PIRVS_WRITE(name, value)

GicV3 gic() { return GicV3(kMachine.gicd, kMachine.gicr, kMachine.cores); }

}  // namespace

void interrupts_start() {
  handlers_size = 0;
  gic().start();
}

void interrupts_start_core() {
  PIRVS_WRITE_BY(PIRVS_ICC_SRE_EL1, PIRVS_READ_BY(PIRVS_ICC_SRE_EL1) | 1);
  asm volatile("isb");
  const Status woken = gic().start_core(kMachine.mpidr[this_core()]);
  PIRVS_ASSERT(woken == Status::kOk);
  PIRVS_WRITE_BY(PIRVS_ICC_PMR_EL1, kEveryPriority);
  PIRVS_WRITE_BY(PIRVS_ICC_IGRPEN1_EL1, 1);
  asm volatile("isb");
  unmask_interrupts();
}

Status interrupt_handle(uint32_t intid, InterruptHandler handler) {
  if (handlers_size == kHandlersMax) return Status::kFull;
  handlers[handlers_size++] = {intid, handler};
  return Status::kOk;
}

void interrupt_enable(uint32_t intid) {
  const Status enabled = gic().enable(intid, kMachine.mpidr[this_core()]);
  PIRVS_ASSERT(enabled == Status::kOk);
}

void interrupt_all_others(uint32_t intid) {
  PIRVS_ASSERT(intid < kMessagesMax);
  asm volatile("dsb ish" ::: "memory");  // they see what was written before
  PIRVS_WRITE_BY(PIRVS_ICC_SGI1R_EL1, kToAllOthers | static_cast<uint64_t>(intid) << 24);
  asm volatile("isb");
}

void interrupt_entry(const ExceptionFrame& frame) {
  const uint32_t intid = static_cast<uint32_t>(PIRVS_READ_BY(PIRVS_ICC_IAR1_EL1));
  if (intid >= kNoInterrupt) return;
  asm volatile("dsb sy" ::: "memory");
  // Ended before it is handled: handlers run masked, and one that restarts leaves nothing open.
  // A level that the handler silences would only be taken once more.
  int i = 0;
  while (i < handlers_size && handlers[i].intid != intid) ++i;
  PIRVS_ASSERT(i < handlers_size);
  PIRVS_WRITE_BY(PIRVS_ICC_EOIR1_EL1, intid);
  handlers[i].handler(intid, frame);
}

}  // namespace pirvs::bsp
