// Reads a decimal number from text, without the C library's strtod and its heap.
// In      [+-]digits[.digits][e[+-]digits], all of the text; no "nan", "inf", hexadecimal, blanks.
// Out     The nearest double for up to 19 digits, of which at most 37 stand behind the point: what
//         was written with 17 digits is read back to the bit. Else, and for more than 15 digits
//         before the point with a positive exponent, it or one beside it. Too large: infinity; too
//         small: 0.
// Errors  false: not a number; `value` stays.
// Cost    ~20 ns; ~0.2 us for more than 15 digits.
// Source  Clinger, PLDI 1990, section 4: the quotient of two exact numbers is rounded once.
#pragma once

#include <string_view>

namespace pirvs {

[[nodiscard]] bool read_number(std::string_view text, double& value);

}  // namespace pirvs
