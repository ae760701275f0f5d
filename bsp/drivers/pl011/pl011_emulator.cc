#include "bsp/drivers/pl011/pl011_emulator.h"

#include "core/base/assert.h"

namespace pirvs::bsp::emulated {

using namespace pl011;

bool Pl011Chip::is_on(uint32_t which) const {
  const uint32_t bits = kCrUarten | which;
  return (file_.peek(kUARTCR) & bits) == bits;
}

uint32_t Pl011Chip::read(uint32_t offset) {
  if (offset == kUARTDR.offset) {
    const char* const c = received_.front();
    PIRVS_ASSERT(is_on(kCrRxe) && c != nullptr);
    const auto value = static_cast<uint8_t>(*c);
    received_.pop();
    return value;
  }
  if (offset == kUARTFR.offset) {
    const uint32_t full = waiting_.size() == kFifo ? kFrTxff : 0;
    const uint32_t empty = received_.size() == 0 ? kFrRxfe : 0;
    if (const char* const c = waiting_.front(); c != nullptr) {
      sent_.put(*c);
      waiting_.pop();
    }
    return full | empty;
  }
  return file_.load(offset);
}

void Pl011Chip::write(uint32_t offset, uint32_t value) {
  if (offset == kUARTDR.offset) {
    const bool taken = waiting_.push(static_cast<char>(value));
    PIRVS_ASSERT(is_on(kCrTxe) && taken);
    return;
  }
  PIRVS_ASSERT(offset != kUARTLCR_H.offset || !is_on(0));
  file_.store(offset, value);
}

}  // namespace pirvs::bsp::emulated
