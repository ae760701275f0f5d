#include "board/usb/image_client.h"

#include <errno.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

namespace pirvs::board {
namespace {

constexpr int kAnswer_ms = 1000;  // pirvsd looks for clients at its frames

}  // namespace

Status ImageClient::connect(const char* path, int camera) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (std::strlen(path) >= sizeof address.sun_path) return Status::kNotFound;
  std::strcpy(address.sun_path, path);
  cameras_ = 1u << camera;
  fd_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd_ < 0) return Status::kBusFault;
  const auto* const to = reinterpret_cast<const sockaddr*>(&address);
  Status status = ::connect(fd_, to, sizeof address) == 0 ? receive_ring() : Status::kNotFound;
  if (status == Status::kOk && !ask(ImageRequest::kNoSlot)) status = Status::kBusFault;
  if (status != Status::kOk) close();
  return status;
}

Status ImageClient::receive_ring() {
  pollfd readable = {fd_, POLLIN, 0};
  if (poll(&readable, 1, kAnswer_ms) <= 0) return Status::kNotFound;
  int memory = -1;
  iovec data = {&ring_, sizeof ring_};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof memory)];
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t got = recvmsg(fd_, &message, MSG_CMSG_CLOEXEC);
  if (got <= 0) return Status::kNotFound;
  const cmsghdr* const rights = CMSG_FIRSTHDR(&message);
  if (rights != nullptr && rights->cmsg_type == SCM_RIGHTS) {
    std::memcpy(&memory, CMSG_DATA(rights), sizeof memory);
  }
  const bool good = got == sizeof ring_ && ring_.magic == kImageMagic && memory >= 0 &&
                    cameras_ >> ring_.cameras == 0 &&
                    uint64_t{ring_.width} * ring_.height <= ring_.slot_bytes;
  void* const at =
      good ? mmap(nullptr, memory_bytes(), PROT_READ, MAP_SHARED, memory, 0) : MAP_FAILED;
  if (memory >= 0) ::close(memory);
  if (at == MAP_FAILED) return Status::kBadData;
  memory_ = static_cast<const uint8_t*>(at);
  return Status::kOk;
}

bool ImageClient::ask(uint32_t slot) {
  const ImageRequest request = {cameras_, slot};
  return send(fd_, &request, sizeof request, MSG_NOSIGNAL) == sizeof request;
}

Status ImageClient::next(ImageReady& out) {
  const ssize_t got = recv(fd_, &out, sizeof out, 0);
  if (got == sizeof out && out.slot < ring_.slots) return Status::kOk;
  if (got < 0 && errno == EAGAIN) return Status::kEmpty;
  close();
  return Status::kStale;
}

void ImageClient::give_back(const ImageReady& image) {
  if (is_open() && !ask(image.slot)) close();
}

void ImageClient::close() {
  if (memory_ != nullptr) munmap(const_cast<uint8_t*>(memory_), memory_bytes());
  if (fd_ >= 0) ::close(fd_);
  memory_ = nullptr;
  fd_ = -1;
}

}  // namespace pirvs::board
