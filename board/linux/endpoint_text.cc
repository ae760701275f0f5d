#include "board/linux/endpoint_text.h"

#include "core/config/key_values.h"

namespace pirvs::board {

const char* read_endpoint(std::string_view value, bsp::Endpoint& out) {
  constexpr const char* kWrong = "not an address and a port, as 192.168.7.2:14550";
  uint32_t address = 0;
  const char* at = value.data();
  const char* const end = at + value.size();
  for (int i = 0; i < 5; ++i) {
    const char* stop = at;
    while (stop < end && *stop != '.' && *stop != ':') ++stop;
    int64_t part = 0;
    if (!read_whole({at, static_cast<size_t>(stop - at)}, i == 4 ? 1 : 0, i == 4 ? 65'535 : 255,
                    part)) {
      return kWrong;
    }
    if (i == 4) {
      if (stop != end) return kWrong;
      out = {address, static_cast<uint16_t>(part)};
      return nullptr;
    }
    if (stop == end || *stop != (i == 3 ? ':' : '.')) return kWrong;
    address = address << 8 | static_cast<uint32_t>(part);
    at = stop + 1;
  }
  return kWrong;
}

}  // namespace pirvs::board
