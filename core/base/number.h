// Reads a decimal number from text, without the C library's strtod and its heap.
// In      [+-]digits[.digits][e[+-]digits], all of the text; no "nan", "inf", hexadecimal, blanks.
// Out     The nearest double or one beside it; exactly the nearest up to 15 digits and a decimal
//         exponent of 22 either way. Too large: infinity; too small: 0.
// Errors  false: not a number; `value` stays.
// Cost    ~20 ns.
// Source  Clinger, PLDI 1990, section 4: the quotient of two exact doubles is rounded once.
#pragma once

#include <string_view>

namespace pirvs {

[[nodiscard]] bool read_number(std::string_view text, double& value);

}  // namespace pirvs
