#include "bsp/api/datagram.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "bsp/linux/datagram.h"

namespace pirvs::bsp {
namespace {

int fd_plus_1[kSocketsMax] = {};  // 0: free

int fd_of(Socket socket) {
  PIRVS_ASSERT(socket.id >= 0 && socket.id < kSocketsMax && fd_plus_1[socket.id] != 0);
  return fd_plus_1[socket.id] - 1;
}

sockaddr_in posix(Endpoint endpoint) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(endpoint.port);
  out.sin_addr.s_addr = htonl(endpoint.address);
  return out;
}

Status status_of_errno() {
  switch (errno) {
    case EAGAIN:
    case ENOBUFS:
    case EMFILE:
    case ENFILE:
      return Status::kFull;
    case EMSGSIZE:
      return Status::kBadData;
    case EAFNOSUPPORT:
      return Status::kNotFound;
    default:
      return Status::kBusFault;
  }
}

}  // namespace

int datagram_fd(Socket socket) { return fd_of(socket); }

// A connected socket has the address of its way; nothing is sent.
Result<uint32_t> datagram_address_towards(Endpoint to) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return Status::kFull;
  sockaddr_in address = posix(to);
  socklen_t size = sizeof address;
  const bool known = connect(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                     getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  close(fd);
  if (!known) return Status::kNotFound;
  return ntohl(address.sin_addr.s_addr);
}

Result<Socket> datagram_open(Endpoint own) {
  int id = 0;
  while (id < kSocketsMax && fd_plus_1[id] != 0) ++id;
  if (id == kSocketsMax) return Status::kFull;
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return status_of_errno();
  // A USB link's address comes with its cable.
  const int yes = 1;
  (void)setsockopt(fd, IPPROTO_IP, IP_FREEBIND, &yes, sizeof yes);
  const sockaddr_in address = posix(own);
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const Status status = status_of_errno();
    close(fd);
    return status;
  }
  fd_plus_1[id] = fd + 1;
  return Socket{id};
}

Result<uint16_t> datagram_port(Socket socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (getsockname(fd_of(socket), reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return status_of_errno();
  }
  return ntohs(address.sin_port);
}

Status datagram_send(Socket socket, Endpoint to, const void* data, size_t size) {
  if (size > kDatagramMax) return Status::kBadData;
  const sockaddr_in address = posix(to);
  const ssize_t sent = sendto(fd_of(socket), data, size, MSG_NOSIGNAL,
                              reinterpret_cast<const sockaddr*>(&address), sizeof address);
  return sent >= 0 ? Status::kOk : status_of_errno();
}

Status datagram_receive(Socket socket, void* data, size_t max, size_t& size, Endpoint& from) {
  sockaddr_in address{};
  socklen_t address_size = sizeof address;
  ssize_t got = 0;
  do {
    got = recvfrom(fd_of(socket), data, max, MSG_TRUNC, reinterpret_cast<sockaddr*>(&address),
                   &address_size);
    // Nobody listens where an earlier datagram of ours went: the network's news, not this call's.
  } while (got < 0 && (errno == EINTR || errno == ECONNREFUSED));
  if (got < 0) return errno == EAGAIN ? Status::kEmpty : status_of_errno();
  from = {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
  size = static_cast<size_t>(got) < max ? static_cast<size_t>(got) : max;
  return static_cast<size_t>(got) <= max ? Status::kOk : Status::kBadData;
}

void datagram_close(Socket socket) {
  close(fd_of(socket));
  fd_plus_1[socket.id] = 0;
}

}  // namespace pirvs::bsp
