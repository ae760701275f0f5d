#include "board/linux/serial_text.h"

#include "bsp/linux/tty.h"
#include "core/config/key_values.h"

namespace pirvs::board {

const char* read_serial(std::string_view value, SettingText& path, int& baud) {
  const size_t colon = value.rfind(':');
  int64_t speed = 0;
  if (colon != std::string_view::npos) {
    const std::string_view text(value.data() + colon + 1, value.size() - colon - 1);
    if (!read_whole(text, 1, 4'000'000, speed) || !bsp::is_baud(speed)) {
      return "no speed of a serial line behind the colon, as 115200, 460800, 921600";
    }
    value = {value.data(), colon};
  }
  if (value.empty()) return "a tty and its speed, as /dev/ttyS1:921600";
  const char* const why = read_text(value, path);
  if (why == nullptr) baud = static_cast<int>(speed);
  return why;
}

}  // namespace pirvs::board
