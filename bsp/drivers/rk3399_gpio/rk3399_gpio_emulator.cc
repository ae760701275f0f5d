#include "bsp/drivers/rk3399_gpio/rk3399_gpio_emulator.h"

namespace pirvs::bsp::emulated {

using namespace rk3399_gpio;

uint32_t Rk3399GpioChip::pins() const {
  const uint32_t outputs = file_.peek(kSWPORTA_DDR);
  return (file_.peek(kSWPORTA_DR) & outputs) | (inputs_ & ~outputs);
}

// Edges are latched; levels are whatever the pin is now.
uint32_t Rk3399GpioChip::raw_status() const {
  const uint32_t edges = file_.peek(kINTTYPE_LEVEL);
  const uint32_t active = ~(pins() ^ file_.peek(kINT_POLARITY));
  return ((latched_ & edges) | (active & ~edges)) & file_.peek(kINTEN);
}

uint32_t Rk3399GpioChip::read(uint32_t offset) {
  file_.poke(kINT_STATUS, status());
  file_.poke(kINT_RAWSTATUS, raw_status());
  file_.poke(kEXT_PORTA, pins());
  return file_.load(offset);
}

void Rk3399GpioChip::write(uint32_t offset, uint32_t value) {
  file_.store(offset, value);
  if (offset == kPORTA_EOI.offset) latched_ &= ~value;
}

void Rk3399GpioChip::set_input(int line, bool level) {
  const uint32_t bit = 1u << line;
  const uint32_t before = pins();
  inputs_ = level ? inputs_ | bit : inputs_ & ~bit;
  latched_ |= (before ^ pins()) & ~(pins() ^ file_.peek(kINT_POLARITY)) & file_.peek(kINTEN);
}

bool Rk3399GpioChip::output(int line) const {
  return ((pins() & file_.peek(kSWPORTA_DDR)) >> line & 1) != 0;
}

}  // namespace pirvs::bsp::emulated
