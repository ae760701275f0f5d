// QEMU's `virt` machine: addresses of hw/arm/virt.c, `a15memmap`.
#include "bsp/bare/machine.h"

#include "bsp/drivers/pl011/pl011.h"

namespace pirvs::bsp {
namespace {

constexpr Pl011 kUart(0x0900'0000);

}  // namespace

extern const Machine kMachine;
const Machine kMachine = {
    "qemu-virt",
    [] { kUart.start(); },
    [](char c) { kUart.write(c); },
    [] { return kUart.read(); },
    0x0800'0000,
    0x080a'0000,
    4,
    {0, 1, 2, 3},
    0x4000'0000,
    true,
};

}  // namespace pirvs::bsp
