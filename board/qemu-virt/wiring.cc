// The eight pins of QEMU's `virt`: a PL061, whose inputs a test drives from outside.
#include "bsp/api/clock.h"
#include "bsp/api/gpio.h"
#include "bsp/bare/interrupts.h"
#include "bsp/drivers/edge_queues.h"
#include "bsp/drivers/pl061/pl061.h"

namespace pirvs::bsp {
namespace {

constexpr uintptr_t kGpio = 0x0903'0000;
constexpr uint32_t kGpioInterrupt = 32 + 7;

EdgeQueues edges;
Pl061 gpio(kGpio, 0, edges);

void handle_gpio(uint32_t, const ExceptionFrame&) {
  const TimeNs t = now();
  gpio.handle_interrupt(t);
}

}  // namespace

Status gpio_direction(Pin pin, PinDirection direction, bool level) {
  return pin.bank == 0 ? gpio.direction(pin.line, direction, level) : Status::kNotFound;
}

Status gpio_write(Pin pin, bool level) {
  return pin.bank == 0 ? gpio.write(pin.line, level) : Status::kNotFound;
}

Result<bool> gpio_read(Pin pin) {
  if (pin.bank != 0) return Status::kNotFound;
  return gpio.read(pin.line);
}

Status gpio_watch(Pin pin, EdgeKind kind) {
  static bool handled = false;
  if (pin.bank != 0) return Status::kNotFound;
  PIRVS_TRY(gpio.watch(pin.line, kind));
  if (handled) return Status::kOk;
  PIRVS_TRY(interrupt_handle(kGpioInterrupt, handle_gpio));
  interrupt_enable(kGpioInterrupt);
  handled = true;
  return Status::kOk;
}

Status gpio_poll(Pin pin, GpioEdge& out) { return edges.poll(pin, out); }

}  // namespace pirvs::bsp
