// Small text files, of a configuration or of sysfs, read whole.
// In      A path; memory for it.
// Out     The text, which ends with a zero.
// Errors  What is wrong with it, for a person: errno's text, or that it is too large; nullptr: it
//         was read.
// Cost    Three system calls. No heap.
#pragma once

#include <cstddef>
#include <string_view>

namespace pirvs::bsp {

[[nodiscard]] const char* read_text_file(const char* path, char* out, size_t max,
                                         std::string_view& text);

}  // namespace pirvs::bsp
