#include "bsp/api/console.h"

#include "bsp/bare/machine.h"

namespace pirvs::bsp {

void console_write(const char* text) {
  for (; *text != 0; ++text) {
    if (*text == '\n') kMachine.uart_write('\r');
    kMachine.uart_write(*text);
  }
}

}  // namespace pirvs::bsp
