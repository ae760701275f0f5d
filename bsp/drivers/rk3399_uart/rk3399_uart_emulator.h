// An emulated UART of the RK3399 for tests of its driver.
// In      The driver's accesses. send_out(n): the time of n bytes passes on the line, at most that
//         many leave the transmitter. receive(): a byte arrives, perhaps damaged.
// Out     sent(): what left, from the first. divisor(): as set.
// Errors  See emulated/register_file.h. A byte written to a full FIFO, or a read of an empty one: a
//         bug of the driver, asserts.
// Source  rk3399_uart_registers.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bsp/drivers/emulated/register_file.h"
#include "bsp/drivers/rk3399_uart/rk3399_uart_registers.h"
#include "core/store/ring.h"

namespace pirvs::bsp::emulated {

class Rk3399UartChip {
 public:
  static constexpr uint32_t kSize = 0x100;
  static constexpr size_t kSentMax = 512;

  uint32_t read(uint32_t offset);
  void write(uint32_t offset, uint32_t value);

  void send_out(int bytes);
  void receive(uint8_t byte, uint32_t line_errors = 0);
  const uint8_t* sent() const { return sent_; }
  size_t sent_size() const { return sent_size_; }
  uint32_t divisor() const { return divisor_; }
  // Another talker keeps the receiver busy.
  void set_line_busy(bool busy) { line_busy_ = busy; }

 private:
  struct Received {
    uint8_t byte;
    uint32_t errors;
  };

  bool divisor_open() const { return (file_.peek(rk3399_uart::kLCR) & 0x80) != 0; }
  bool busy() const { return line_busy_ || tx_.size() > 0; }
  uint32_t line_status();
  uint8_t take();

  RegisterFile file_{rk3399_uart::kRegisters};
  Ring<uint8_t, rk3399_uart::kFifoBytes> tx_;
  Ring<Received, rk3399_uart::kFifoBytes> rx_;
  uint8_t sent_[kSentMax] = {};
  size_t sent_size_ = 0;
  uint32_t divisor_ = 0;
  bool overrun_ = false;
  bool line_busy_ = false;
};

}  // namespace pirvs::bsp::emulated
