// Serial ports of a machine that has one UART, the console's: port 0 is that one, as fast as the
// loader or uart_start has left it.
#include "bsp/api/serial.h"

#include "bsp/bare/machine.h"

namespace pirvs::bsp {

Status serial_open(int port, uint32_t) { return port == 0 ? Status::kOk : Status::kNotFound; }

size_t serial_write(int, const uint8_t* data, size_t size) {
  for (size_t i = 0; i < size; ++i) kMachine.uart_write(static_cast<char>(data[i]));
  return size;
}

Status serial_read(int, uint8_t* data, size_t max, size_t& count) {
  count = 0;
  for (int byte = 0; count < max && (byte = kMachine.uart_read()) >= 0;) {
    data[count++] = static_cast<uint8_t>(byte);
  }
  return count > 0 ? Status::kOk : Status::kEmpty;
}

}  // namespace pirvs::bsp
