#include "bsp/drivers/icm20602/icm20602_emulator.h"

#include <algorithm>

namespace pirvs::bsp::emulated {

using namespace icm20602;

void Icm20602Chip::reset() {
  std::fill_n(memory_, sizeof memory_, uint8_t{0});
  memory_[kWHO_AM_I] = kIdentity;
  memory_[kPWR_MGMT_1] = kPwrMgmt1AfterReset;
  fifo_size_ = 0;
}

bool Icm20602Chip::start(uint8_t address_and_read) {
  place_comes_ = (address_and_read & 1) == 0;
  return address_and_read >> 1 == address_;
}

bool Icm20602Chip::write(uint8_t byte) {
  if (place_comes_) {
    place_ = byte & 0x7f;
  } else {
    store(place_, byte);
    place_ = (place_ + 1) & 0x7f;
  }
  place_comes_ = false;
  return true;
}

void Icm20602Chip::store(uint8_t address, uint8_t value) {
  if (address == kPWR_MGMT_1 && (value & kDeviceReset) != 0) return reset();
  if (address == kUSER_CTRL && (value & kFifoReset) != 0) fifo_size_ = 0;
  if (address == kWHO_AM_I || address == kFIFO_COUNTH || address == kFIFO_COUNTL) return;
  memory_[address] = address == kUSER_CTRL ? value & ~kFifoReset : value;
}

uint8_t Icm20602Chip::take() {
  if (fifo_size_ == 0) return 0xff;
  const uint8_t first = fifo_[0];
  std::copy(fifo_ + 1, fifo_ + fifo_size_, fifo_);
  --fifo_size_;
  return first;
}

uint8_t Icm20602Chip::read(bool) {
  if (place_ == kFIFO_R_W) return take();
  const uint8_t address = place_;
  place_ = (place_ + 1) & 0x7f;
  if (address == kFIFO_COUNTH) return static_cast<uint8_t>(fifo_size_ >> 8);
  if (address == kFIFO_COUNTL) return static_cast<uint8_t>(fifo_size_);
  return memory_[address];
}

bool Icm20602Chip::sample(const int16_t (&f)[3], const int16_t (&w)[3]) {
  if (bit(kPWR_MGMT_1, 0x40)) return false;  // asleep
  const bool stores = bit(kUSER_CTRL, kFifoEnable) && bit(kFIFO_EN, 0x18);
  if (stores && fifo_size_ + kPacketBytes <= kFifoBytes) {
    const int16_t words[] = {f[0], f[1], f[2], 0x0123, w[0], w[1], w[2]};
    for (const int16_t word : words) {
      put(static_cast<uint8_t>(static_cast<uint16_t>(word) >> 8));
      put(static_cast<uint8_t>(word));
    }
  }
  return bit(kINT_ENABLE, 0x01);
}

}  // namespace pirvs::bsp::emulated
