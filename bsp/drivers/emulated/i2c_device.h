// A chip on an emulated I2C bus: 256 registers of a byte behind an address that counts up.
// In      What a master does on the bus, as the controller's emulator hands it on.
// Out     ack of a byte; bytes read. The first byte written after a start sets the place.
// Errors  refuse_after: that many bytes are taken in a transfer, the next is refused.
//         was_released: the master refused the last byte it read, as it must, or the chip would go
//         on and hold the data line.
// Source  NXP UM10204; InvenSense and ST sensors' register access.
#pragma once

#include <cstdint>

namespace pirvs::bsp::emulated {

class I2cDevice {
 public:
  explicit I2cDevice(uint8_t address) : address_(address) {}

  bool start(uint8_t address_and_read) {
    written_ = 0;
    return address_and_read >> 1 == address_;
  }
  bool write(uint8_t byte) {
    if (written_ >= refuse_after) return false;
    if (written_++ == 0) {
      place_ = byte;
    } else {
      memory[place_++] = byte;
    }
    return true;
  }
  uint8_t read(bool acked) {
    was_released = !acked;
    return memory[place_++];
  }

  uint8_t memory[256] = {};
  int refuse_after = 1000;
  bool was_released = true;

 private:
  uint8_t address_;
  uint8_t place_ = 0;
  int written_ = 0;
};

}  // namespace pirvs::bsp::emulated
