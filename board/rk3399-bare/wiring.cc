// What is wired where on the RK3399 board: pins, clocks, and the chips behind bsp/api/gpio.h, i2c.h
// and trigger.h. Pin numbers are those of the 40-pin header of a ROCK Pi 4 (docs/board-bringup.md).
#include "bsp/api/clock.h"
#include "bsp/api/gpio.h"
#include "bsp/api/i2c.h"
#include "bsp/api/trigger.h"
#include "bsp/bare/interrupts.h"
#include "bsp/drivers/edge_queues.h"
#include "bsp/drivers/rk3399_gpio/rk3399_gpio.h"
#include "bsp/drivers/rk3399_i2c/rk3399_i2c.h"
#include "bsp/drivers/rk3399_pwm/rk3399_pwm.h"
#include "bsp/drivers/rk3399_setup/rk3399_setup.h"

namespace pirvs::bsp {
namespace {

using namespace rk3399_setup;

constexpr uint32_t kI2cDivider = 3;

// A bit that is 0 after its mask lets a clock run.
constexpr SetupRow kSetup[] = {
    {kGrf, kGPIO2A_IOMUX, 3 << 14, 2 << 14, "A7, pin 3: I2C7_SDA"},
    {kGrf, kGPIO2B_IOMUX, 3 << 0, 2 << 0, "B0, pin 5: I2C7_SCL"},
    {kGrf, kGPIO4C_IOMUX, 3 << 4, 1 << 4, "C2, pin 11: PWM_0, camera trigger"},
    {kGrf, kGPIO4D_IOMUX, 3 << 4, 0, "D2, pin 16: GPIO, robot"},
    {kGrf, kGPIO4D_IOMUX, 3 << 8, 0, "D4, pin 18: GPIO, robot"},
    {kGrf, kGPIO4D_IOMUX, 3 << 10, 0, "D5, pin 22: GPIO, robot"},
    {kCru, kCLKSEL_CON63, 0xff << 8, 1 << 15 | (kI2cDivider - 1) << 8, "clk_i2c7: GPLL / 3"},
    {kCru, kCLKGATE_CON10, 1 << 5, 0, "clk_i2c7"},
    {kCru, kCLKGATE_CON22, 1 << 5, 0, "pclk_rki2c7"},
    {kCru, kCLKGATE_CON31, 1 << 5, 0, "pclk_gpio4"},
    {kPmuCru, kPMU_CLKGATE_CON1, 1 << 10, 0, "pclk_rkpwm_pmu"},
};
static_assert(is_setup(kSetup));

constexpr uint8_t kGpioBank = 4;
constexpr uint32_t kGpio4Interrupt = 32 + 18;
constexpr uintptr_t kI2c7 = 0xff16'0000, kPwm0 = 0xff42'0000, kGpio4 = 0xff79'0000;
constexpr uint32_t kScl_hz = 400'000;

EdgeQueues edges;
Rk3399Gpio gpio4(kGpio4, kGpioBank, edges);
Rk3399I2c i2c7(kI2c7, 0);

// The first call of any kind sets up the pins; what another master undid since, it does again.
void set_up() {
  size_t which = 0;
  if (holds(kSetup, which) != Status::kOk) apply(kSetup);
}

void handle_gpio4(uint32_t, const ExceptionFrame&) {
  const TimeNs t = now();
  gpio4.handle_interrupt(t);
}

}  // namespace

Status gpio_direction(Pin pin, PinDirection direction, bool level) {
  if (pin.bank != kGpioBank) return Status::kNotFound;
  set_up();
  return gpio4.direction(pin.line, direction, level);
}

Status gpio_write(Pin pin, bool level) {
  return pin.bank == kGpioBank ? gpio4.write(pin.line, level) : Status::kNotFound;
}

Result<bool> gpio_read(Pin pin) {
  if (pin.bank != kGpioBank) return Status::kNotFound;
  return gpio4.read(pin.line);
}

Status gpio_watch(Pin pin, EdgeKind kind) {
  if (pin.bank != kGpioBank) return Status::kNotFound;
  static bool handled = false;
  set_up();
  PIRVS_TRY(gpio4.watch(pin.line, kind));
  if (handled) return Status::kOk;
  PIRVS_TRY(interrupt_handle(kGpio4Interrupt, handle_gpio4));
  interrupt_enable(kGpio4Interrupt);
  handled = true;
  return Status::kOk;
}

Status gpio_poll(Pin pin, GpioEdge& out) { return edges.poll(pin, out); }

Status i2c_start(int bus, const I2cTransfer& transfer) {
  static bool open = false;
  if (bus != 7) return Status::kNotFound;
  if (!open) {
    set_up();
    i2c7 = Rk3399I2c(kI2c7, gpll_hz() / kI2cDivider);
    PIRVS_TRY(i2c7.open(kScl_hz));
    open = true;
  }
  return i2c7.start(transfer, now());
}

Status i2c_poll(int bus) { return bus == 7 ? i2c7.poll(now()) : Status::kNotFound; }

Result<TriggerStart> trigger_start(int output, const TriggerTiming& timing) {
  if (output != 0) return Status::kNotFound;
  set_up();
  return Rk3399Pwm(kPwm0, pmu_pclk_hz()).start(timing);
}

Status trigger_stop(int output) {
  if (output != 0) return Status::kNotFound;
  Rk3399Pwm(kPwm0, 0).stop();
  return Status::kOk;
}

}  // namespace pirvs::bsp
