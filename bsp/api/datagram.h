// Datagrams to and from other programs and computers: poses out, commands in. Each arrives whole or
// not at all, perhaps twice, and in any order.
// In      datagram_open: the address to receive at, which also says from where: programs of this
//         machine alone (loopback, the default), the network of one interface (its address, which
//         need not be there yet), or everybody (kAnyAddress); the port, 0 for any free one. Each
//         socket from one core.
// Out     datagram_send: handed to the network. datagram_receive: the oldest one waiting, its size
//         and where it came from. datagram_port: the port that the socket got.
// Errors  open: kFull (too many sockets), kBusFault (port taken, or not ours to take), kNotFound
//         (no network). send: kFull: no room now, the datagram is lost; kBadData: longer than
//         kDatagramMax; kBusFault. receive: kEmpty: nothing waits; kBadData: it was longer than
//         `max`, its tail is lost; kBusFault.
// Cost    One system call each, ~5 us. Neither waits; bsp/api/events.h does.
// Source  RFC 768 (UDP); kDatagramMax is what one Ethernet frame carries without fragments.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/status.h"

namespace pirvs::bsp {

inline constexpr int kSocketsMax = 4;
inline constexpr size_t kDatagramMax = 1472;

struct Endpoint {
  uint32_t address = 0x7f00'0001;  // IPv4, 127.0.0.1
  uint16_t port = 0;
};

struct Socket {
  int id = -1;
};

inline constexpr uint32_t kAnyAddress = 0;

Result<Socket> datagram_open(Endpoint own);
Result<uint16_t> datagram_port(Socket socket);
Status datagram_send(Socket socket, Endpoint to, const void* data, size_t size);
Status datagram_receive(Socket socket, void* data, size_t max, size_t& size, Endpoint& from);
void datagram_close(Socket socket);

}  // namespace pirvs::bsp
