// Interrupts of this core: who handles which.
// In      A handler per interrupt number (INTID): 0..15 from other cores, 16..31 of this core,
//         32 and on of devices. Handlers run on the core that is interrupted, one at a time.
// Out     interrupts_start_core: this core takes interrupts from here on.
//         interrupt_all_others: INTID 0..15 to every other running core.
// Errors  An interrupt that nobody handles is a bug and asserts. kFull: no free row.
// Cost    ~400 instructions from the device to the handler.
// Source  GICv3 specification, IHI 0069.
#pragma once

#include <cstdint>

#include "bsp/bare/exception.h"
#include "core/base/status.h"

namespace pirvs::bsp {

using InterruptHandler = void (*)(uint32_t intid, const ExceptionFrame& frame);

void interrupts_start();       // once, on core 0
void interrupts_start_core();  // on each core, core 0 too
// From core 0 before others run; device interrupts go to core 0.
Status interrupt_handle(uint32_t intid, InterruptHandler handler);
void interrupt_enable(uint32_t intid);  // 16..31: on this core alone
void interrupt_all_others(uint32_t intid);
void interrupt_entry(const ExceptionFrame& frame);  // from the vectors

}  // namespace pirvs::bsp
