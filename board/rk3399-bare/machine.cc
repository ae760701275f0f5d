// Rockchip RK3399, started by U-Boot: addresses of the TRM's memory map (part 1, chapter 2).
#include "bsp/bare/machine.h"

#include "bsp/drivers/rk3399_uart/rk3399_uart.h"

namespace pirvs::bsp {
namespace {

constexpr uint32_t kConsoleBaud = 1'500'000;          // as U-Boot leaves it
constexpr Rk3399Uart kUart(0xff1a'0000, 24'000'000);  // UART2, pins GPIO4_C3 and C4

void start_console() {
  // If the line is never silent, U-Boot's own setting stays, which is the same.
  if (kUart.open(kConsoleBaud) != Status::kOk) return;
}

int read_console() {
  uint8_t byte = 0;
  size_t count = 0;
  (void)kUart.read(&byte, 1, count);
  return count == 0 ? -1 : byte;
}

}  // namespace

extern const Machine kMachine;
const Machine kMachine = {
    "rk3399-bare",
    start_console,
    [](char c) { kUart.put(static_cast<uint8_t>(c)); },
    read_console,
    0xfee0'0000,
    0xfef0'0000,
    6,
    {0x000, 0x001, 0x002, 0x003, 0x100, 0x101},
    0,
    false,
};

}  // namespace pirvs::bsp
