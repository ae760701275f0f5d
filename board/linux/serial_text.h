// A serial line and its speed as text, /dev/ttyS1:921600.
// Out     The path alone; baud, 0: without a speed, as the line is set.
// Errors  nullptr, or what is wrong; then both stay.
#pragma once

#include "board/linux/setting_text.h"

namespace pirvs::board {

const char* read_serial(std::string_view value, SettingText& path, int& baud);

}  // namespace pirvs::board
