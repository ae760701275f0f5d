#include "bsp/drivers/rk3399_i2c/rk3399_i2c_emulator.h"

namespace pirvs::bsp::emulated {

using namespace rk3399_i2c;

uint32_t Rk3399I2cChip::scl_hz(uint32_t clock_hz) const {
  const uint32_t divider = file_.peek(kCLKDIV);
  return clock_hz / (8 * ((divider >> 16) + 1 + (divider & 0xffff) + 1));
}

void Rk3399I2cChip::raise(uint32_t events) {
  if (!held_) coming_ |= events;
}

uint32_t Rk3399I2cChip::read(uint32_t offset) {
  if (offset >= kRXDATA0.offset) return rx_[(offset - kRXDATA0.offset) / 4 % kDataWords];
  const uint32_t value = file_.load(offset);
  if (offset == kIPD.offset) {
    file_.poke(kIPD, value | coming_);
    coming_ = 0;
  }
  return value;
}

void Rk3399I2cChip::write(uint32_t offset, uint32_t value) {
  if (offset >= kTXDATA0.offset && offset < kRXDATA0.offset) {
    tx_[(offset - kTXDATA0.offset) / 4 % kDataWords] = value;
    return;
  }
  const uint32_t before = file_.peek(kCON);
  file_.store(offset, value);
  if (offset == kCON.offset) control(before, value);
  if (offset == kMTXCNT.offset) transmit(value);
  if (offset == kMRXCNT.offset) receive(value);
}

void Rk3399I2cChip::control(uint32_t before, uint32_t value) {
  if ((value & kConEnable) == 0) {
    started_ = false;
    coming_ = 0;
    return;
  }
  if ((value & ~before & kConStart) != 0) {
    started_ = true;
    addressed_ = false;
    raise(kIpdStart);
  }
  if ((value & ~before & kConStop) != 0) {
    started_ = false;
    raise(kIpdStop);
  }
}

// A byte on the bus: the first after a START is an address.
bool Rk3399I2cChip::put(uint8_t byte) {
  const bool acked = addressed_ ? device_.write(byte) : device_.start(byte);
  addressed_ |= acked;
  return acked;
}

void Rk3399I2cChip::transmit(uint32_t count) {
  PIRVS_ASSERT(started_ && count > 0 && count <= kMessageBytes);
  PIRVS_ASSERT((file_.peek(kCON) & (kConModeMask | kConStart)) == kConModeTx);
  for (uint32_t i = 0; i < count; ++i) {
    if (!put(static_cast<uint8_t>(tx_[i / 4] >> (i % 4 * 8)))) return raise(kIpdNack);
  }
  raise(kIpdTxDone);
}

void Rk3399I2cChip::receive(uint32_t count) {
  const uint32_t control = file_.peek(kCON);
  PIRVS_ASSERT(started_ && count > 0 && count <= kMessageBytes && (control & kConStart) == 0);
  if ((control & kConModeMask) == kConModeAddressRx) {
    const uint32_t address = file_.peek(kMRXADDR), place = file_.peek(kMRXRADDR);
    PIRVS_ASSERT((address & address_valid(0)) != 0);
    if (!put(static_cast<uint8_t>(address))) return raise(kIpdNack);
    for (uint32_t i = 0; i < 3 && (place & address_valid(i)) != 0; ++i) {
      if (!put(static_cast<uint8_t>(place >> (8 * i)))) return raise(kIpdNack);
    }
  } else {
    PIRVS_ASSERT((control & kConModeMask) == kConModeRx && addressed_);
  }
  for (uint32_t& word : rx_) word = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const bool acked = i + 1 < count || (control & kConLastNack) == 0;
    rx_[i / 4] |= uint32_t{device_.read(acked)} << (i % 4 * 8);
  }
  raise(kIpdRxDone | kIpdStart);
}

}  // namespace pirvs::bsp::emulated
