#include "board/linux/watchdog.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "bsp/linux/watchdog.h"

namespace pirvs::board {
namespace {

// systemd's end of NOTIFY_SOCKET; "@name" lies in the abstract name space.
int connect_to_systemd() {
  const char* const name = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (name == nullptr || name[0] == 0 || std::strlen(name) >= sizeof address.sun_path) return -1;
  std::strcpy(address.sun_path, name);
  if (name[0] == '@') address.sun_path[0] = 0;
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + std::strlen(name));
  if (fd >= 0 && connect(fd, reinterpret_cast<const sockaddr*>(&address), size) == 0) return fd;
  if (fd >= 0) ::close(fd);
  return -1;
}

}  // namespace

const char* Watchdog::open(const char* node, const bsp::DeviceNews& news) {
  teller_.configure(news);
  socket_ = connect_to_systemd();
  if (node[0] == 0) return nullptr;
  node_ = ::open(node, O_WRONLY | O_CLOEXEC);
  if (node_ < 0) {
    return errno == EBUSY ? "another program has the watchdog: systemd, by RuntimeWatchdogSec?"
                          : std::strerror(errno);
  }
  int timeout_s = kTimeout_s;
  (void)ioctl(node_, WDIOC_SETTIMEOUT, &timeout_s);  // else its own counts
  return nullptr;
}

void Watchdog::notify(const char* text) const {
  if (socket_ >= 0) (void)::send(socket_, text, std::strlen(text), MSG_NOSIGNAL);
}

void Watchdog::ready() {
  if (ready_) return;
  ready_ = true;
  notify("READY=1\nSTATUS=sensors deliver");
}

void Watchdog::poll() {
  if (node_ < 0 && socket_ < 0) return;
  const TimeNs t = bsp::now();
  if (t < next_t_) return;
  next_t_ = t + kEvery_ns;
  if (const char* const task = bsp::stuck_task(kHang_ns)) {
    teller_.tell(task, "this task hangs: the watchdog is no longer kicked");
    return;
  }
  if (node_ >= 0) (void)!write(node_, "k", 1);
  notify("WATCHDOG=1");
}

void Watchdog::close() {
  notify("STOPPING=1");
  if (socket_ >= 0) ::close(socket_);
  if (node_ >= 0) {
    (void)!write(node_, "V", 1);
    ::close(node_);
  }
  node_ = socket_ = -1;
}

}  // namespace pirvs::board
