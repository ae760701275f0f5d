// What a processor says about an exception, in words.
// In      ESR_EL1, FAR_EL1; whether it was a system error.
// Out     For example "null access: write at 0x8, not mapped".
// Errors  A class without words here is given as a number.
// Source  Arm ARM D13.2.37 (ESR_EL1).
#pragma once

#include <cstdint>

#include "core/base/text.h"

namespace pirvs::bsp {

bool is_data_abort(uint64_t syndrome);
void put_syndrome(TextWriter& out, bool system_error, uint64_t syndrome, uint64_t address);

}  // namespace pirvs::bsp
