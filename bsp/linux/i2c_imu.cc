#include "bsp/linux/i2c_imu.h"

#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

#include "bsp/api/clock.h"
#include "core/base/assert.h"

namespace pirvs::bsp {
namespace {

constexpr int kPoll_ms = 20;  // without an edge, to see that there is none

void sleep_for(TimeNs duration) {
  const timespec time{0, static_cast<long>(duration)};
  nanosleep(&time, nullptr);
}

}  // namespace

void I2cImu::configure(const I2cImuSetup& setup, const DeviceNews& news) {
  PIRVS_ASSERT(!started_);
  setup_ = setup;
  teller_.configure(news);
  not_found_ = data_ready_.find(&setup_.data_ready, 1);
  if (!start()) tell("no thread for the IMU");
}

bool I2cImu::start() {
  event_fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (event_fd_ < 0) return false;
  stop_ = false;
  const auto entry = [](void* self) -> void* {
    static_cast<I2cImu*>(self)->run();
    return nullptr;
  };
  if (pthread_create(&thread_, nullptr, entry, this) != 0) return false;
  started_ = true;
  const sched_param param{kPriority};
  if (setup_.urgent) (void)pthread_setschedparam(thread_, SCHED_FIFO, &param);
  return true;
}

void I2cImu::close() {
  if (started_) {
    stop_ = true;
    pthread_join(thread_, nullptr);
    started_ = false;
  }
  if (event_fd_ >= 0) ::close(event_fd_);
  event_fd_ = -1;
  here_ = false;
}

// ---- the door's core ---------------------------------------------------------------------------

Status I2cImu::poll(ImuSample& out) {
  if (!started_) return gone_.answer();
  const Sampled* sampled = samples_.front();
  if (sampled == nullptr) {
    uint64_t events = 0;
    (void)!read(event_fd_, &events, sizeof events);
    sampled = samples_.front();  // one that came in between has left no event behind
  }
  if (sampled == nullptr) return here_ ? Status::kEmpty : gone_.answer();
  out = sampled->sample;
  const bool after_loss = sampled->after_loss;
  samples_.pop();
  return after_loss ? Status::kFull : Status::kOk;
}

Status I2cImu::temperature(float& degrees_C) const {
  degrees_C = temperature_C_;
  return temperature_known_ ? Status::kOk : Status::kEmpty;
}

// ---- the IMU's thread --------------------------------------------------------------------------

const char* I2cImu::open() {
  if (not_found_ != nullptr) return not_found_;
  if (const char* const why = data_ready_.open(EdgeKind::kRising, "pirvsd")) return why;
  chip_.emplace(setup_.bus, setup_.address);
  told_ = {};
  switch (chip_->set_up()) {
    case Status::kOk:
      break;
    case Status::kNotFound:
      return "no ICM-20602 answers there: no such bus, no right to it, or another chip";
    default:
      return "the bus has an error: is the IMU connected, and its address right?";
  }
  GpioEdge old;
  while (data_ready_.poll(old) != Status::kEmpty) continue;  // of before the set-up
  errors_in_row_ = 0;
  edges_come_ = false;
  return nullptr;
}

void I2cImu::run() {
  while (!stop_) {
    if (const char* const why = open()) {
      data_ready_.close();
      tell(why);
      for (TimeNs t = now(); !stop_ && now() < t + kRetry_ns;) sleep_for(kRetry_ns / 10);
      continue;
    }
    ++counters_.opened;
    tell("IMU started");
    here_ = true;
    while (!stop_ && serve()) continue;
    here_ = false;
    data_ready_.close();
    if (!stop_) {
      ++counters_.unplugged;
      tell("IMU gone, waiting for it");
    }
  }
}

// From one edge to the next. False: it is gone.
bool I2cImu::serve() {
  pollfd ready{data_ready_.fd(), POLLIN, 0};
  ::poll(&ready, 1, kPoll_ms);
  GpioEdge edge;
  Status status = Status::kOk;
  while ((status = data_ready_.poll(edge)) == Status::kOk || status == Status::kFull) {
    chip_->data_ready(edge.t);
    edges_come_ = true;
  }
  if (status == Status::kBusFault) return false;
  counters_.edges_lost += data_ready_.lost() - counters_.edges_lost;
  do {
    if (!step()) return false;
  } while (chip_->busy());
  hand_over();
  return true;
}

bool I2cImu::step() {
  const Status status = chip_->step(now());
  return status == Status::kOk || recover(status);
}

// False: it is gone.
bool I2cImu::recover(Status status) {
  if (status == Status::kStale && !edges_come_) {  // to set it up again would change nothing
    tell("no data-ready edges come: is imu.data_ready the pin of its interrupt?");
    return true;
  }
  if (status == Status::kStale || status == Status::kBadData) {
    ++(status == Status::kStale ? counters_.silent : counters_.resets);
    tell(status == Status::kStale ? "data-ready edges are missing: setting the IMU up anew"
                                  : "the IMU was reset: setting it up anew");
    edges_come_ = false;
    if (chip_->set_up() == Status::kOk) return true;
  }
  ++counters_.bus_errors;
  return ++errors_in_row_ < kErrorsMax;
}

void I2cImu::hand_over() {
  bool any = false, lost = false;
  for (;;) {
    Sampled sampled;
    const Status status = chip_->poll(sampled.sample);
    if (status == Status::kEmpty) break;
    sampled.after_loss = status == Status::kFull || lost;
    sampled.sample.t -= setup_.delay_ns;
    lost = !samples_.push(sampled);
    if (lost) {
      ++counters_.lost;
    } else {
      ++counters_.samples;
    }
    any = true;
  }
  const Icm20602::Counters& now_counted = chip_->counters();
  counters_.lost += now_counted.lost - told_.lost;
  counters_.guessed += now_counted.guessed - told_.guessed;
  counters_.rejected += now_counted.rejected - told_.rejected;
  told_ = now_counted;
  if (!any) return;
  errors_in_row_ = 0;
  tell("IMU started");  // again, after it was set up anew
  temperature_C_ = chip_->temperature_C();
  temperature_known_ = true;
  const uint64_t one = 1;
  (void)!write(event_fd_, &one, sizeof one);
}

}  // namespace pirvs::bsp
