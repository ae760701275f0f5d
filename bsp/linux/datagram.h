// The file descriptor of a socket of bsp/api/datagram.h, for bsp/linux/events.h: bsp::wait then
// ends when a datagram comes.
// Errors  A socket that is not open is a bug and asserts.
#pragma once

#include "bsp/api/datagram.h"

namespace pirvs::bsp {

int datagram_fd(Socket socket);

}  // namespace pirvs::bsp
