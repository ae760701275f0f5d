#include "tools/update/device_link.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

#include "tools/dataset/input_error.h"
#include "tools/network/resolve.h"

namespace pirvs::tools {
namespace {

void set_silence(int fd, int option, int seconds) {
  const timeval limit = {seconds, 0};
  setsockopt(fd, SOL_SOCKET, option, &limit, sizeof limit);
}

// A device that lost its power does not close its connections.
void keep_alive(int fd) {
  const int on = 1, idle_s = 10, interval_s = 5, probes = 4;
  setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof idle_s);
  setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &interval_s, sizeof interval_s);
  setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
}

}  // namespace

DeviceLink::DeviceLink(const std::string& host) : host_(host) {
  const Addresses addresses = resolve(host, kUpdatePort, SOCK_STREAM);
  fd_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd_ < 0) throw LinkError(std::strerror(errno));
  set_silence(fd_, SO_SNDTIMEO, kConnect_s_max);  // of connect, too
  if (connect(fd_, addresses->ai_addr, addresses->ai_addrlen) != 0) {
    const int why = errno == EINPROGRESS ? ETIMEDOUT : errno;
    close(fd_);
    throw LinkError(host + ": " + std::strerror(why));
  }
  set_silence(fd_, SO_SNDTIMEO, kSilence_s_max);
  set_silence(fd_, SO_RCVTIMEO, kSilence_s_max);
  keep_alive(fd_);
}

DeviceLink::~DeviceLink() { close(fd_); }

void DeviceLink::send(const std::string& text) {
  size_t done = 0;
  while (done < text.size()) {
    const ssize_t sent = ::send(fd_, text.data() + done, text.size() - done, MSG_NOSIGNAL);
    if (sent <= 0) throw LinkError(host_ + ": the connection broke: " + std::strerror(errno));
    done += static_cast<size_t>(sent);
  }
}

void DeviceLink::send_file(const std::string& path, uint64_t bytes,
                           const std::function<void(uint64_t)>& progress) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(1 << 18);
  for (uint64_t done = 0; done < bytes;) {
    if (has_input()) return;
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    if (file.gcount() <= 0) {
      throw InputError("the file became shorter while it was read", path, "copy it first");
    }
    send(std::string(block.data(), static_cast<size_t>(file.gcount())));
    done += static_cast<uint64_t>(file.gcount());
    progress(done);
  }
}

bool DeviceLink::has_input() const {
  pollfd in = {fd_, POLLIN, 0};
  return poll(&in, 1, 0) == 1;
}

bool DeviceLink::read_line(std::string& out) {
  size_t end = 0;
  while ((end = pending_.find('\n')) == std::string::npos) {
    char block[512];
    const ssize_t got = recv(fd_, block, sizeof block, 0);
    if (got < 0 && errno == EAGAIN) throw LinkError(host_ + ": the device says nothing any more");
    if (got <= 0) return false;
    pending_.append(block, static_cast<size_t>(got));
  }
  out = pending_.substr(0, end);
  pending_.erase(0, end + 1);
  return true;
}

}  // namespace pirvs::tools
