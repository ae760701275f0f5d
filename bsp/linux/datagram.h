// Linux's side of bsp/api/datagram.h.
// Out     datagram_fd(): the descriptor of a socket, for bsp/linux/events.h: bsp::wait then ends
//         when a datagram comes. datagram_address_towards(): which of this machine's addresses
//         leads to another one.
// Errors  A socket that is not open is a bug and asserts. datagram_address_towards: kNotFound: no
//         network leads there now; kFull: no descriptor is left.
#pragma once

#include "bsp/api/datagram.h"

namespace pirvs::bsp {

int datagram_fd(Socket socket);
Result<uint32_t> datagram_address_towards(Endpoint to);

}  // namespace pirvs::bsp
