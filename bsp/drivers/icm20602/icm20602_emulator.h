// An emulated ICM-20602 for tests of its driver.
// In      Bytes on the bus; sample(): the sensor has measured, in raw units.
// Out     sample() says whether INT pulsed. reset(): as by a brown-out.
// Frames  the chip's axes.
// Errors  none.
// Source  icm20602_registers.h. FIFO_R_W is the one address that does not count up.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/drivers/icm20602/icm20602_registers.h"

namespace pirvs::bsp::emulated {

class Icm20602Chip {
 public:
  explicit Icm20602Chip(uint8_t address) : address_(address) { reset(); }

  bool start(uint8_t address_and_read);
  bool write(uint8_t byte);
  uint8_t read(bool acked);

  void reset();
  bool sample(const int16_t (&f)[3], const int16_t (&w)[3]);
  size_t fifo_size() const { return fifo_size_; }
  uint8_t& memory(uint8_t address) { return memory_[address]; }

 private:
  bool bit(uint8_t address, uint8_t mask) const { return (memory_[address] & mask) == mask; }
  void put(uint8_t byte) { fifo_[fifo_size_++] = byte; }
  uint8_t take();
  void store(uint8_t address, uint8_t value);

  uint8_t address_;
  uint8_t place_ = 0;
  bool place_comes_ = true;
  uint8_t memory_[128] = {};
  uint8_t fifo_[icm20602::kFifoBytes] = {};
  size_t fifo_size_ = 0;
};

}  // namespace pirvs::bsp::emulated
