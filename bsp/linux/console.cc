#include "bsp/api/console.h"

#include <cstdio>

namespace pirvs::bsp {

void console_write(const char* text) { std::fputs(text, stderr); }

}  // namespace pirvs::bsp
