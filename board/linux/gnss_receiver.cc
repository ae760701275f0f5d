#include "board/linux/gnss_receiver.h"

#include <errno.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "bsp/linux/cores.h"
#include "bsp/linux/datagram.h"
#include "bsp/linux/tty.h"
#include "core/math/square.h"

namespace pirvs::board {

void widen_by(double sigma_ns, GnssFix& fix) {
  constexpr double kAccel_m_s2 = 2;  // of a vehicle, in which its velocity is off
  const double sigma_s = 1e-9 * sigma_ns;
  // Not measured: as fast as a fast vehicle is.
  constexpr double kUnknown_m_s = 10;
  const double horizontal = fix.has_velocity ? fix.v_ned.head<2>().norm() : kUnknown_m_s;
  const bool has_down = fix.has_velocity && std::isfinite(fix.v_ned.z());
  const double vertical = has_down ? std::fabs(fix.v_ned.z()) : horizontal;
  const auto widen = [sigma_s](double& sigma, double rate) {
    sigma = std::sqrt(square(sigma) + square(rate * sigma_s));
  };
  widen(fix.sigma_horizontal_m, horizontal);
  widen(fix.sigma_vertical_m, vertical);
  if (fix.has_velocity) widen(fix.sigma_velocity_m_s, kAccel_m_s2);
}

const char* GnssReceiver::open(const GnssSettings& settings, const GnssSinks& sinks) {
  settings_ = settings;
  sinks_ = sinks;
  news_.configure(sinks.news);
  clock_.configure(settings.latency_ns);
  if (!settings_.has_udp) return nullptr;  // the line is looked for, again and again
  const Result<bsp::Socket> socket = bsp::datagram_open(settings_.udp);
  if (!socket.ok()) return "cannot bind that address and port: in use, or no permission";
  socket_ = socket.value();
  has_socket_ = true;
  fd_ = bsp::datagram_fd(socket_);
  byte_t_ = fix_t_ = sinks_.now();
  ++counters_.opened;
  return nullptr;
}

const char* GnssReceiver::start_thread() {
  stop_ = false;
  const auto entry = [](void* self) -> void* {
    static_cast<GnssReceiver*>(self)->run();
    return nullptr;
  };
  if (pthread_create(&thread_, nullptr, entry, this) != 0) return "no thread";
  runs_ = true;
  return nullptr;
}

void GnssReceiver::close() {
  if (runs_) {
    stop_ = true;
    pthread_join(thread_, nullptr);
    runs_ = false;
  }
  if (has_socket_) {
    bsp::datagram_close(socket_);
  } else if (fd_ >= 0) {
    ::close(fd_);
  }
  has_socket_ = false;
  fd_ = -1;
}

// ---- the line ----------------------------------------------------------------------------------

const char* GnssReceiver::open_line() {
  fd_ = bsp::tty_open(settings_.serial.text, settings_.baud);
  if (fd_ < 0) {
    switch (errno) {
      case ENOENT:
      case ENODEV:
      case ENXIO:
        return "no receiver there, it is looked for";
      case EACCES:
      case EPERM:
        return "no permission, which the group dialout has";
      case EBUSY:
        return "busy, another program has it";
      default:
        return "cannot be opened";
    }
  }
  if (isatty(fd_) == 0) {
    ::close(fd_);
    fd_ = -1;
    return "is no serial line";
  }
  (void)ioctl(fd_, TIOCEXCL);  // two readers would each have half of the bytes
  return nullptr;
}

void GnssReceiver::look_for_it(TimeNs now) {
  if (fd_ >= 0 || now < retry_t_) return;
  retry_t_ = now + kRetry_ns;
  const bool was_there = counters_.opened > 0;
  if (const char* const why = open_line()) return news_.tell(device(), why);
  ++counters_.opened;
  byte_t_ = fix_t_ = now;
  burst_t_ = INT64_MIN;
  if (was_there) news_.tell(device(), "back");
}

void GnssReceiver::lose(const char* why) {
  ::close(fd_);
  fd_ = -1;
  news_.tell(device(), why);
}

// How many bytes there were.
size_t GnssReceiver::receive(uint8_t* bytes, size_t max) {
  if (has_socket_) {
    size_t size = 0;
    bsp::Endpoint from;
    return bsp::datagram_receive(socket_, bytes, max, size, from) == Status::kOk ? size : 0;
  }
  const ssize_t got = read(fd_, bytes, max);
  if (got > 0) return static_cast<size_t>(got);
  if (got == 0 || (errno != EAGAIN && errno != EINTR)) lose("gone, it is looked for");
  return 0;
}

void GnssReceiver::judge_silence(TimeNs now) {
  if (fd_ < 0) return;
  if (now - byte_t_ > kSilent_ns) {
    news_.tell(device(), "silent: is it wired and set to send?");
  } else if (now - fix_t_ > kSilent_ns) {
    news_.tell(device(), "bytes come, but no fix by UBX or NMEA: is the speed right?");
  }
}

// ---- fixes -------------------------------------------------------------------------------------

// Above kRate_hz_max for more than a second.
bool GnssReceiver::is_flood(TimeNs now) {
  constexpr TimeNs kOne_ns = 1'000'000'000 / kRate_hz_max;
  const TimeNs more = std::min<TimeNs>((now - credit_t_) / kOne_ns, kRate_hz_max);
  if (more > 0) credit_t_ = now;
  credit_ = std::min(credit_ + static_cast<int>(more), kRate_hz_max);
  if (credit_ == 0) return true;
  --credit_;
  return false;
}

void GnssReceiver::take(const ReceiverFix& read, TimeNs arrival) {
  fix_t_ = arrival;
  ReceiverStamp stamp = clock_.stamp_without_time(arrival);
  Status status = Status::kOk;
  if (!read.has_time) {
    ++counters_.without_time;
  } else if (read.overdue) {
    status = clock_.stamp(read.t_utc, stamp);
  } else {
    status = clock_.stamp(read.t_utc, arrival, stamp);
  }
  const bool goes_on = status == Status::kOk && stamp.t > stamp_t_;
  if (status == Status::kOk) stamp_t_ = stamp.t;  // a clock that was set back goes on from there
  if (!goes_on) {
    ++counters_.odd;
    return;
  }
  if (is_flood(sinks_.now())) {
    ++counters_.flood;
    return;
  }
  GnssFix fix = read.fix;
  fix.t = stamp.t;
  if (fix.type != GnssFixType::kNone) widen_by(stamp.sigma_ns, fix);
  counters_.sigma_us = static_cast<uint32_t>(std::lround(1e-3 * stamp.sigma_ns));
  if (sinks_.deliver(sinks_.context, arrival_of(fix)) != Status::kOk) {
    ++counters_.not_delivered;
    return;
  }
  ++counters_.fixes;
  if (stamp.by_pulse) ++counters_.by_pulse;
  news_.tell(device(), stamp.by_pulse ? "fixes come, stamped by its pulse per second"
                                      : "fixes come, stamped by when they come");
}

void GnssReceiver::take_bytes(const uint8_t* bytes, size_t size, TimeNs now) {
  constexpr TimeNs kPause_ns = 20'000'000;  // between the bytes of two fixes
  counters_.bytes += static_cast<uint32_t>(size);
  if (now - byte_t_ > kPause_ns || byte_t_ == INT64_MIN) burst_t_ = now;
  byte_t_ = now;
  ReceiverFix read;
  for (size_t i = 0; i < size; ++i) {
    if (!reader_.take(bytes[i], read)) continue;
    // What is told first of an epoch may be told long after its first byte, at a slow line.
    take(read, burst_t_ != INT64_MIN ? burst_t_ : now);
    burst_t_ = INT64_MIN;
  }
}

void GnssReceiver::pulse(const bsp::Pps& pps) {
  // Full: the thread is late, and the next pulse says the same.
  (void)pulses_.push({pps.second_t(), pps.rate_ppb(), pps.sigma_ns()});
}

void GnssReceiver::poll() {
  const TimeNs begin = sinks_.now();
  look_for_it(begin);
  while (const ReceiverSecond* const second = pulses_.front()) {
    clock_.pulse(*second);
    pulses_.pop();
  }
  uint8_t bytes[1024];
  size_t heard = 0;
  while (fd_ >= 0 && heard < kBytesAtOnce) {
    const size_t got = receive(bytes, sizeof bytes);
    if (got == 0) break;
    heard += got;
    take_bytes(bytes, got, sinks_.now());
  }
  judge_silence(sinks_.now());
}

void GnssReceiver::run() {
  constexpr int kRest_ms = 200;
  bsp::leave_cores();
  while (!stop_) {
    poll();
    const timespec rest = {0, 1'000'000};  // whoever floods us is heard so often
    (void)nanosleep(&rest, nullptr);
    pollfd fd = {fd_, POLLIN, 0};
    (void)::poll(&fd, fd_ >= 0 ? 1 : 0, kRest_ms);
  }
}

}  // namespace pirvs::board
