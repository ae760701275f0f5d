// An address and a port as text, 192.168.7.2:14550.
// Errors  nullptr, or what is wrong; then `out` stays.
#pragma once

#include <string_view>

#include "bsp/api/datagram.h"

namespace pirvs::board {

const char* read_endpoint(std::string_view value, bsp::Endpoint& out);

}  // namespace pirvs::board
