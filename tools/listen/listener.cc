#include "tools/listen/listener.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "bsp/api/clock.h"
#include "tools/dataset/input_error.h"
#include "tools/network/resolve.h"

namespace pirvs::tools {
namespace {

constexpr int kPort = 14560;
constexpr char kFileMagic[8] = {'P', 'V', 'S', 'T', 'R', 'E', 'A', '1'};
constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr uint16_t kLease_s = 5;

}  // namespace

Listener::Listener(const std::string& from, uint32_t kinds) : kinds_(kinds) {
  if (std::filesystem::is_regular_file(from)) {
    file_ = std::fopen(from.c_str(), "rb");
    char magic[sizeof kFileMagic];
    const bool ours = file_ != nullptr && std::fread(magic, sizeof magic, 1, file_) == 1 &&
                      std::memcmp(magic, kFileMagic, sizeof magic) == 0;
    if (ours) return;
    if (file_ != nullptr) std::fclose(file_);
    throw InputError("not a recorded stream", from, "give a file of `pirvs listen --record`");
  }
  connect_to(from);
}

Listener::~Listener() {
  if (fd_ >= 0) {
    uint8_t bytes[stream::kMax];
    const size_t size = stream::encode(stream::SubscribeMessage{0, 0}, bytes);
    (void)!send(fd_, bytes, size, 0);
    close(fd_);
  }
  if (file_ != nullptr) std::fclose(file_);
  if (record_ != nullptr) std::fclose(record_);
}

void Listener::connect_to(const std::string& device) {
  const Addresses addresses = resolve(device, kPort, SOCK_DGRAM);
  fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd_ < 0 || connect(fd_, addresses->ai_addr, addresses->ai_addrlen) != 0) {
    throw InputError(std::string("cannot be reached, ") + std::strerror(errno), device,
                     "is its network up?");
  }
  const int room = 4 << 20;  // while this program writes files
  (void)setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
}

void Listener::record(const std::string& path) {
  record_path_ = path;
  record_ = std::fopen(path.c_str(), "wb");
  if (record_ == nullptr || std::fwrite(kFileMagic, sizeof kFileMagic, 1, record_) != 1) {
    throw InputError(std::strerror(errno), path, "give another file");
  }
}

// ---- files: time, size, bytes ------------------------------------------------------------------

void Listener::write(const Datagram& datagram) {
  const auto size = static_cast<uint16_t>(datagram.size);
  const bool good = std::fwrite(&datagram.t_arrival, sizeof datagram.t_arrival, 1, record_) == 1 &&
                    std::fwrite(&size, sizeof size, 1, record_) == 1 &&
                    std::fwrite(datagram.bytes, 1, size, record_) == size;
  if (!good) throw InputError(std::strerror(errno), record_path_, "give another file");
}

// A last datagram that was cut off ends the file.
bool Listener::read(Datagram& out) {
  uint16_t size = 0;
  const bool head = std::fread(&out.t_arrival, sizeof out.t_arrival, 1, file_) == 1 &&
                    std::fread(&size, sizeof size, 1, file_) == 1 && size <= sizeof out.bytes;
  at_end_ = !head || std::fread(out.bytes, 1, size, file_) != size;
  out.size = size;
  return !at_end_;
}

// ---- network -----------------------------------------------------------------------------------

void Listener::ask(TimeNs now) {
  if (now < ask_t_) return;
  ask_t_ = now + kSecond_ns;
  uint8_t bytes[stream::kMax];
  size_t size = stream::encode(stream::SubscribeMessage{kinds_, kLease_s}, bytes);
  (void)!send(fd_, bytes, size, 0);  // a device that is not there yet will be asked again
  size = stream::encode(stream::ClockMessage{bsp::now(), 0}, stream::Kind::kAskClock, 0, bytes);
  (void)!send(fd_, bytes, size, 0);
}

bool Listener::receive(Datagram& out, TimeNs patience_ns) {
  const TimeNs end = bsp::now() + patience_ns;
  for (TimeNs now = bsp::now(); now < end; now = bsp::now()) {
    ask(now);
    pollfd ready{fd_, POLLIN, 0};
    constexpr TimeNs kMilli = 1'000'000;
    const TimeNs wait = std::min(end, ask_t_) - now;
    if (poll(&ready, 1, static_cast<int>(wait / kMilli) + 1) <= 0) continue;
    const ssize_t got = recv(fd_, out.bytes, sizeof out.bytes, 0);
    if (got < 0) continue;  // nobody listens there yet
    out.t_arrival = bsp::now();
    out.size = static_cast<size_t>(got);
    return true;
  }
  return false;
}

// Half of the round trip each way: off by half of it at most.
void Listener::take_clock(const Datagram& datagram) {
  stream::Header header;
  stream::ClockMessage answer;
  if (!stream::decode(datagram.bytes, datagram.size, header) ||
      header.kind != stream::Kind::kClock ||
      !stream::decode(header, datagram.bytes + stream::kHeaderBytes, answer)) {
    return;
  }
  const TimeNs round_trip = datagram.t_arrival - answer.t_host;
  if (round_trip < 0 || round_trip >= clock_.round_trip_ns) return;
  clock_.known = true;
  clock_.round_trip_ns = round_trip;
  clock_.offset_ns = answer.t_device - answer.t_host - round_trip / 2;
}

bool Listener::next(Datagram& out, TimeNs patience_ns) {
  if (file_ != nullptr) {
    if (at_end_ || !read(out)) return false;
  } else {
    if (!receive(out, patience_ns)) return false;
    if (record_ != nullptr) write(out);
  }
  heard_ = true;
  take_clock(out);
  return true;
}

}  // namespace pirvs::tools
