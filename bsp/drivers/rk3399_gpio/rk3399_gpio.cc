#include "bsp/drivers/rk3399_gpio/rk3399_gpio.h"

#include "bsp/drivers/rk3399_gpio/rk3399_gpio_registers.h"

namespace pirvs::bsp {

using namespace rk3399_gpio;

Status Rk3399Gpio::direction(uint8_t line, PinDirection direction, bool level) {
  if (line >= kLines) return Status::kNotFound;
  const uint32_t bit = 1u << line;
  const bool output = direction == PinDirection::kOutput;
  if (output) PIRVS_TRY(write(line, level));  // before the pin is driven
  registers_.change(kSWPORTA_DDR, bit, output ? bit : 0);
  return Status::kOk;
}

Status Rk3399Gpio::write(uint8_t line, bool level) {
  if (line >= kLines) return Status::kNotFound;
  const uint32_t bit = 1u << line;
  registers_.change(kSWPORTA_DR, bit, level ? bit : 0);
  return Status::kOk;
}

Result<bool> Rk3399Gpio::read(uint8_t line) const {
  if (line >= kLines) return Status::kNotFound;
  return (registers_.read(kEXT_PORTA) >> line & 1) != 0;
}

Status Rk3399Gpio::watch(uint8_t line, EdgeKind kind) {
  if (line >= kLines) return Status::kNotFound;
  PIRVS_TRY(edges_.watch({bank_, line}));
  const uint32_t bit = 1u << line;
  const bool both = kind == EdgeKind::kBoth;
  registers_.change(kINTMASK, bit, bit);
  registers_.change(kINTEN, bit, kind == EdgeKind::kNone ? 0 : bit);
  registers_.change(kDEBOUNCE, bit, 0);  // it would delay the edge by up to two slow clocks
  registers_.change(kLS_SYNC, bit, bit);
  registers_.change(kINTTYPE_LEVEL, bit, both ? 0 : bit);
  const bool waits_for_high =
      both ? (registers_.read(kEXT_PORTA) & bit) == 0 : kind == EdgeKind::kRising;
  registers_.change(kINT_POLARITY, bit, waits_for_high ? bit : 0);
  registers_.write(kPORTA_EOI, bit);  // what was latched under the old setting
  both_ = both ? both_ | bit : both_ & ~bit;
  registers_.change(kINTMASK, bit, kind == EdgeKind::kNone ? bit : 0);
  return Status::kOk;
}

void Rk3399Gpio::handle_interrupt(TimeNs t) {
  const uint32_t pending = registers_.read(kINT_STATUS);
  const uint32_t levels = registers_.read(kINT_POLARITY);
  registers_.write(kPORTA_EOI, pending);
  if ((pending & both_) != 0) registers_.write(kINT_POLARITY, levels ^ (pending & both_));
  for (uint8_t line = 0; line < kLines; ++line) {
    const uint32_t bit = 1u << line;
    if ((pending & bit) != 0) edges_.push({t, {bank_, line}, (levels & bit) != 0});
  }
}

}  // namespace pirvs::bsp
