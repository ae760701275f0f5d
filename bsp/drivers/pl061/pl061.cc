#include "bsp/drivers/pl061/pl061.h"

#include "bsp/drivers/pl061/pl061_registers.h"

namespace pirvs::bsp {

using namespace pl061;

Status Pl061::direction(uint8_t line, PinDirection direction, bool level) {
  if (line >= kLines) return Status::kNotFound;
  const uint32_t bit = 1u << line;
  const bool output = direction == PinDirection::kOutput;
  // The chip ignores data written to an input, so the level can only follow the direction.
  registers_.change(kGPIODIR, bit, output ? bit : 0);
  return output ? write(line, level) : Status::kOk;
}

Status Pl061::write(uint8_t line, bool level) {
  if (line >= kLines) return Status::kNotFound;
  const uint32_t bit = 1u << line;
  registers_.write_at(kGPIODATA, bit, level ? bit : 0);
  return Status::kOk;
}

Result<bool> Pl061::read(uint8_t line) const {
  if (line >= kLines) return Status::kNotFound;
  const uint32_t bit = 1u << line;
  return registers_.read_at(kGPIODATA, bit) != 0;
}

Status Pl061::watch(uint8_t line, EdgeKind kind) {
  if (line >= kLines) return Status::kNotFound;
  PIRVS_TRY(edges_.watch({bank_, line}));
  const uint32_t bit = 1u << line;
  registers_.change(kGPIOIE, bit, 0);
  registers_.change(kGPIOIS, bit, 0);  // edges, not levels
  registers_.change(kGPIOIBE, bit, kind == EdgeKind::kBoth ? bit : 0);
  registers_.change(kGPIOIEV, bit, kind == EdgeKind::kRising ? bit : 0);
  registers_.write(kGPIOIC, bit);  // what was latched under the old setting
  registers_.change(kGPIOIE, bit, kind == EdgeKind::kNone ? 0 : bit);
  return Status::kOk;
}

void Pl061::handle_interrupt(TimeNs t) {
  const uint32_t pending = registers_.read(kGPIOMIS);
  // Cleared before the level is read: an edge after this line raises the interrupt again.
  registers_.write(kGPIOIC, pending);
  const uint32_t both = registers_.read(kGPIOIBE);
  const uint32_t rising = registers_.read(kGPIOIEV);
  const uint32_t data = registers_.read_at(kGPIODATA, 0xff);
  const uint32_t levels = (both & data) | (~both & rising);
  for (uint8_t line = 0; line < kLines; ++line) {
    const uint32_t bit = 1u << line;
    if ((pending & bit) != 0) edges_.push({t, {bank_, line}, (levels & bit) != 0});
  }
}

}  // namespace pirvs::bsp
