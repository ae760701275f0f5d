#include "bsp/drivers/pl061/pl061_emulator.h"

namespace pirvs::bsp::emulated {

using namespace pl061;

uint32_t Pl061Chip::pins() const {
  const uint32_t outputs = file_.peek(kGPIODIR);
  return (driven_ & outputs) | (inputs_ & ~outputs);
}

uint32_t Pl061Chip::read(uint32_t offset) {
  if (offset < kGPIODIR.offset) return pins() & (offset >> 2);
  file_.poke(kGPIORIS, latched_);
  file_.poke(kGPIOMIS, masked());
  return file_.load(offset);
}

void Pl061Chip::write(uint32_t offset, uint32_t value) {
  if (offset < kGPIODIR.offset) {
    const uint32_t mask = (offset >> 2) & file_.peek(kGPIODIR);
    driven_ = (driven_ & ~mask) | (value & mask);
    return;
  }
  file_.store(offset, value & 0xff);
  if (offset == kGPIOIC.offset) latched_ &= ~value;
}

void Pl061Chip::set_input(int line, bool level) {
  const uint32_t bit = 1u << line;
  const uint32_t before = pins();
  inputs_ = level ? inputs_ | bit : inputs_ & ~bit;
  const uint32_t changed = before ^ pins();
  const uint32_t wanted = file_.peek(kGPIOIBE) | ~(pins() ^ file_.peek(kGPIOIEV));
  latched_ |= changed & wanted & ~file_.peek(kGPIOIS) & 0xff;
}

bool Pl061Chip::output(int line) const {
  return ((driven_ & file_.peek(kGPIODIR)) >> line & 1) != 0;
}

}  // namespace pirvs::bsp::emulated
