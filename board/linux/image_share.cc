#include "board/linux/image_share.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

#include "bsp/api/clock.h"

namespace pirvs::board {
namespace {

constexpr size_t kPage = 4096;

bool make_address(const char* path, sockaddr_un& out) {
  out = {};
  out.sun_family = AF_UNIX;
  if (std::strlen(path) >= sizeof out.sun_path) return false;
  std::strcpy(out.sun_path, path);
  return true;
}

// The last folder of the path; /run is empty after each start.
void make_folder_of(const sockaddr_un& address) {
  char folder[sizeof address.sun_path];
  std::memcpy(folder, address.sun_path, sizeof folder);
  char* const slash = std::strrchr(folder, '/');
  if (slash == nullptr || slash == folder) return;
  *slash = 0;
  (void)mkdir(folder, 0755);  // bind() tells when this was in vain
}

// What a predecessor has left, and nothing that is not a socket.
void remove_socket(const char* path) {
  struct stat about;
  if (lstat(path, &about) == 0 && S_ISSOCK(about.st_mode)) (void)unlink(path);
}

}  // namespace

Status ImageShare::make_memory() {
  const size_t size = size_t{ring_.slots} * ring_.slot_bytes;
  memory_fd_ = memfd_create("pirvs-images", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (memory_fd_ < 0 || ftruncate(memory_fd_, static_cast<off_t>(size)) != 0) {
    return Status::kBusFault;
  }
  void* const at = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, memory_fd_, 0);
  if (at == MAP_FAILED) return Status::kBusFault;
  memory_ = static_cast<uint8_t*>(at);
  std::memset(memory_, 0, size);  // its pages are there before the first image
  constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
  return fcntl(memory_fd_, F_ADD_SEALS, kSeals) == 0 ? Status::kOk : Status::kBusFault;
}

Status ImageShare::open(const char* path, int cameras, int width, int height) {
  PIRVS_ASSERT(!is_open());
  path_ = path;
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  ring_.cameras = static_cast<uint32_t>(cameras);
  ring_.width = static_cast<uint32_t>(width);
  ring_.height = static_cast<uint32_t>(height);
  ring_.slots = kSlots;
  ring_.slot_bytes = static_cast<uint32_t>((pixels + kPage - 1) / kPage * kPage);
  sockaddr_un address;
  if (!make_address(path, address)) return Status::kBusFault;
  make_folder_of(address);
  remove_socket(path);
  listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const bool listens =
      listener_ >= 0 &&
      bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      chmod(path, 0660) == 0 && listen(listener_, 1) == 0;
  const Status status = listens ? make_memory() : Status::kBusFault;
  if (status != Status::kOk) close();
  return status;
}

void ImageShare::close() {
  drop_client();
  if (memory_ != nullptr) munmap(memory_, size_t{ring_.slots} * ring_.slot_bytes);
  int* const fds[] = {&memory_fd_, &listener_};
  for (int* const fd : fds) {
    if (*fd >= 0) ::close(*fd);
    *fd = -1;
  }
  memory_ = nullptr;
  remove_socket(path_);
  path_ = "";
}

// ---- the client --------------------------------------------------------------------------------

void ImageShare::look_for_client(TimeNs now) {
  if (now < asked_t_ + kAsk_ns) return;
  asked_t_ = now;
  const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (client < 0) return;
  if (client_ < 0) return welcome(client);
  ++counters_.refused;
  ::close(client);
}

void ImageShare::welcome(int client) {
  client_ = client;
  wanted_ = with_client_ = lost_ = 0;
  ++counters_.clients;
  iovec data = {&ring_, sizeof ring_};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof memory_fd_)] = {};
  msghdr message{};
  message.msg_iov = &data;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  cmsghdr* const rights = CMSG_FIRSTHDR(&message);
  rights->cmsg_level = SOL_SOCKET;
  rights->cmsg_type = SCM_RIGHTS;
  rights->cmsg_len = CMSG_LEN(sizeof memory_fd_);
  std::memcpy(CMSG_DATA(rights), &memory_fd_, sizeof memory_fd_);
  if (sendmsg(client_, &message, MSG_NOSIGNAL) != sizeof ring_) drop_client();
}

void ImageShare::drop_client() {
  if (client_ >= 0) ::close(client_);
  client_ = -1;
  wanted_ = with_client_ = 0;
}

bool ImageShare::obey(const ImageRequest& request) {
  if (request.cameras >> ring_.cameras != 0) return false;
  wanted_ = request.cameras;
  if (request.slot == ImageRequest::kNoSlot) return true;
  if (request.slot >= ring_.slots || (with_client_ >> request.slot & 1) == 0) return false;
  with_client_ &= ~(1u << request.slot);
  return true;
}

void ImageShare::listen_to_client() {
  ImageRequest request;
  for (;;) {
    const ssize_t got = recv(client_, &request, sizeof request, MSG_TRUNC);
    if (got < 0 && errno == EAGAIN) return;
    if (got == sizeof request && obey(request)) continue;
    counters_.refused += got > 0;
    return drop_client();
  }
}

// ---- images ------------------------------------------------------------------------------------

void ImageShare::share(const StereoFrame& frame, int camera) {
  const ImageView& image = frame.image[camera];
  uint32_t slot = 0;
  while (slot < ring_.slots && (with_client_ >> slot & 1) != 0) ++slot;
  const bool fits = static_cast<uint32_t>(image.width) == ring_.width &&
                    static_cast<uint32_t>(image.height) == ring_.height;
  ImageReady ready;
  if (slot < ring_.slots && fits) {
    uint8_t* to = memory_ + size_t{slot} * ring_.slot_bytes;
    for (int y = 0; y < image.height; ++y, to += image.width) {
      std::memcpy(to, image.row(y), static_cast<size_t>(image.width));
    }
    ready.t = frame.t - frame.late[camera];
    ready.slot = slot;
    ready.camera = static_cast<uint32_t>(camera);
    ready.sequence = frame.info[camera].sequence;
    ready.lost = lost_;
    if (send(client_, &ready, sizeof ready, MSG_NOSIGNAL) == sizeof ready) {
      with_client_ |= 1u << slot;
      ++counters_.sent;
      return;
    }
    if (errno != EAGAIN) return drop_client();
  }
  ++lost_;
  ++counters_.lost;
}

void ImageShare::frame(const StereoFrame& frame) {
  if (!is_open()) return;
  if (client_ >= 0) listen_to_client();
  look_for_client(bsp::now());
  for (int camera = 0; camera < kCamerasMax; ++camera) {
    const bool wanted = (wanted_ & frame.present) >> camera & 1;
    if (client_ >= 0 && wanted) share(frame, camera);
  }
}

}  // namespace pirvs::board
