// Emulated I2C buses: bsp/api/i2c.h answered by emulated chips. Linked on hosts only.
// In      I2cAttachment(bus, device): as long as it lives, the device hears what is sent there.
//         T has bool start(address_and_read), bool write(byte), uint8_t read(acked), as
//         emulated/i2c_device.h. i2c_fail_next: the outcome of the next transfer, which reaches no
//         device.
// Out     bsp/api/i2c.h; a transfer ends at the second poll. i2c_transfers: how many have ended.
// Errors  As bsp/api/i2c.h.
// Cost    One thread.
// Source  bsp/api/i2c.h.
#pragma once

#include <cstdint>

#include "bsp/api/i2c.h"

namespace pirvs::bsp::emulated {

inline constexpr int kI2cDevicesMax = 4;

struct I2cSlave {
  int bus = -1;  // free
  void* self = nullptr;
  bool (*start)(void* self, uint8_t address_and_read) = nullptr;
  bool (*write)(void* self, uint8_t byte) = nullptr;
  uint8_t (*read)(void* self, bool acked) = nullptr;
};

class I2cAttachment {
 public:
  template <class T>
  I2cAttachment(int bus, T& device)
      : slot_(attach({bus, &device,
                      [](void* self, uint8_t byte) { return static_cast<T*>(self)->start(byte); },
                      [](void* self, uint8_t byte) { return static_cast<T*>(self)->write(byte); },
                      [](void* self, bool acked) { return static_cast<T*>(self)->read(acked); }})) {
  }
  ~I2cAttachment() { detach(slot_); }
  I2cAttachment(const I2cAttachment&) = delete;
  I2cAttachment& operator=(const I2cAttachment&) = delete;

 private:
  static int attach(const I2cSlave& slave);
  static void detach(int slot);

  int slot_;
};

void i2c_fail_next(Status status);
int i2c_transfers();

}  // namespace pirvs::bsp::emulated
