#include "board/linux/robot_link.h"

#include <errno.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "bsp/linux/cores.h"
#include "bsp/linux/datagram.h"
#include "bsp/linux/tty.h"

namespace pirvs::board {

const char* RobotLink::open(const LinkSettings& setup, const ImuNoise& noise, App& app,
                            TimeNs (*now)()) {
  const Result<int> consumer = app.poses().attach();
  if (!consumer.ok()) return "too many take poses";
  consumer_ = consumer.value();
  setup_ = setup;
  app_ = &app;
  now_ = now;
  LinkStack stack;
  stack.context = &app;
  stack.command = [](void* to, const Command& c) { return static_cast<App*>(to)->command(c); };
  stack.deliver = [](void* to, const Arrival& a) { return static_cast<App*>(to)->deliver(a); };
  const auto send = [](void* self, const uint8_t* frame, size_t size) {
    return static_cast<RobotLink*>(self)->send(frame, size);
  };
  link_.configure(setup.link, noise, stack, {this, send});
  return nullptr;
}

const char* RobotLink::start_thread() {
  stop_ = false;
  const auto entry = [](void* self) -> void* {
    static_cast<RobotLink*>(self)->run();
    return nullptr;
  };
  if (pthread_create(&thread_, nullptr, entry, this) != 0) return "no thread";
  runs_ = true;
  return nullptr;
}

void RobotLink::close() {
  if (runs_) {
    stop_ = true;
    pthread_join(thread_, nullptr);
    runs_ = false;
  }
  if (app_ == nullptr) return;
  poll();  // the last poses and news
  app_->poses().detach(consumer_);
  close_serial();
  if (has_socket_) bsp::datagram_close(socket_);
  has_socket_ = false;
  app_ = nullptr;
}

// ---- the wire ----------------------------------------------------------------------------------

uint16_t RobotLink::port() const {
  if (!has_socket_) return 0;
  const Result<uint16_t> port = bsp::datagram_port(socket_);
  return port.ok() ? port.value() : uint16_t{0};
}

void RobotLink::open_wire(TimeNs now) {
  const bool wants_socket = setup_.has_udp && !has_socket_;
  const bool wants_serial = setup_.serial.text[0] != 0 && fd_ < 0;
  if ((!wants_socket && !wants_serial) || (now < retry_t_ && retry_t_ - now <= kRetry_ns)) return;
  retry_t_ = now + kRetry_ns;
  if (wants_serial) {
    fd_ = bsp::tty_open(setup_.serial.text, setup_.baud);
    waiting_from_ = waiting_end_ = 0;
    counters_.opened += fd_ >= 0;
  }
  if (!wants_socket) return;
  // Of our addresses the one that leads there, so that no other network reaches the socket.
  const Result<uint32_t> own = bsp::datagram_address_towards(setup_.udp);
  if (!own.ok()) return;
  const Result<bsp::Socket> socket = bsp::datagram_open({own.value(), setup_.own_port});
  if (!socket.ok()) return;
  socket_ = socket.value();
  has_socket_ = true;
  ++counters_.opened;
}

void RobotLink::close_serial() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

// False: the line has no room, or is gone.
bool RobotLink::flush() {
  while (fd_ >= 0 && waiting_from_ < waiting_end_) {
    const ssize_t written = write(fd_, waiting_ + waiting_from_, waiting_end_ - waiting_from_);
    if (written > 0) {
      waiting_from_ += static_cast<size_t>(written);
    } else if (written < 0 && errno == EINTR) {
      continue;
    } else {
      if (written < 0 && errno != EAGAIN) close_serial();
      return false;
    }
  }
  return fd_ >= 0;
}

bool RobotLink::send(const uint8_t* frame, size_t size) {
  bool sent = false;
  if (has_socket_) {
    sent = bsp::datagram_send(socket_, setup_.udp, frame, size) == Status::kOk;
  }
  if (fd_ >= 0 && flush()) {
    std::memcpy(waiting_, frame, size);
    waiting_from_ = 0;
    waiting_end_ = size;
    (void)flush();
    sent = true;
  }
  return sent;
}

// True: there was as much as is heard at once.
bool RobotLink::receive() {
  uint8_t bytes[bsp::kDatagramMax];
  size_t heard = 0;
  while (has_socket_ && heard < kBytesAtOnce) {
    size_t size = 0;
    bsp::Endpoint from;
    const Status status = bsp::datagram_receive(socket_, bytes, sizeof bytes, size, from);
    if (status != Status::kOk && status != Status::kBadData) break;
    constexpr size_t kDatagram = 64;  // what an empty one costs, too
    heard += size + kDatagram;
    if (from.address != setup_.udp.address) {
      ++counters_.strangers;
    } else {
      link_.receive(now_(), bytes, size);
    }
  }
  while (fd_ >= 0 && heard < kBytesAtOnce) {
    const ssize_t got = read(fd_, bytes, sizeof bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got == 0 || (got < 0 && errno != EAGAIN)) close_serial();
    if (got <= 0) break;
    heard += static_cast<size_t>(got);
    link_.receive(now_(), bytes, static_cast<size_t>(got));
  }
  return heard >= kBytesAtOnce;
}

// ---- the stack ---------------------------------------------------------------------------------

void RobotLink::health(HealthState state, const char* what) {
  if (app_ == nullptr) return;
  News* const news = news_.begin_push();
  if (news == nullptr) return;
  *news = News{};
  news->state = state;
  for (size_t i = 0; i + 1 < sizeof news->what && what[i] != 0; ++i) news->what[i] = what[i];
  news_.end_push();
}

void RobotLink::answer(const Answer& answer) {
  if (app_ == nullptr) return;
  News* const news = news_.begin_push();
  if (news == nullptr) return;
  *news = News{};
  news->is_answer = true;
  news->answer = answer;
  news_.end_push();
}

void RobotLink::take_news() {
  while (const News* const news = news_.front()) {
    if (news->is_answer) {
      link_.answer(news->answer);
    } else {
      link_.health(news->state, news->what);
    }
    news_.pop();
  }
}

void RobotLink::poll() {
  if (app_ == nullptr) return;
  const TimeNs now = now_();
  open_wire(now);
  (void)flush();
  const bool flooded = receive();
  take_news();
  while (const Pose* const pose = app_->poses().next(consumer_)) {
    pose_t_ = now;
    link_.pose(*pose);
  }
  counters_.poses_overtaken = static_cast<uint32_t>(app_->poses().lost(consumer_));
  link_.poll(now);
  if (runs_) wait(flooded);
}

// ---- the thread --------------------------------------------------------------------------------

void RobotLink::wait(bool flooded) {
  constexpr int kRest_ms = 20;         // without poses; with them:
  constexpr int kBetweenPoses_ms = 2;  // half of an IMU's period
  constexpr TimeNs kPosesStop_ns = 200'000'000;
  if (flooded) {
    const timespec rest = {0, 1'000'000};
    (void)nanosleep(&rest, nullptr);
    return;
  }
  pollfd fds[2];
  nfds_t count = 0;
  if (has_socket_) fds[count++] = {bsp::datagram_fd(socket_), POLLIN, 0};
  if (fd_ >= 0) fds[count++] = {fd_, POLLIN, 0};
  const bool poses_come = now_() - pose_t_ < kPosesStop_ns;
  (void)::poll(fds, count, poses_come ? kBetweenPoses_ms : kRest_ms);
}

void RobotLink::run() {
  bsp::leave_cores();
  while (!stop_) poll();
}

}  // namespace pirvs::board
