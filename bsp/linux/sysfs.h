// Files of sysfs: a line of text each.
// In      A path; a buffer with room for an end.
// Out     read_line: the text up to the first newline. value_of: what stands behind `KEY=` in the
//         lines of a text, uevent's; empty: there is no such line.
// Errors  False: no such file, no permission, or the driver refuses; errno says which. value_of has
//         none.
// Cost    Three system calls. No heap.
// Source  Documentation/filesystems/sysfs.rst of Linux.
#pragma once

#include <cstddef>
#include <string_view>

namespace pirvs::bsp {

[[nodiscard]] bool read_file(const char* path, char* out, size_t max);
[[nodiscard]] bool read_line(const char* path, char* out, size_t max);
[[nodiscard]] bool write_file(const char* path, const char* text);
std::string_view value_of(std::string_view lines, std::string_view key);

}  // namespace pirvs::bsp
