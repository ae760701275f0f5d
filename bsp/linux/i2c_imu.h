// The IMU as a chip on /dev/i2c-N whose interrupt is a pin: the driver of bsp/drivers/icm20602, on
// a thread of its own, since its transfers sleep.
// In      configure(), which starts the thread, then poll(), close(): from one core. bsp::i2c_start
//         must mean that bus.
// Out     poll: as imu_poll. t: of the data-ready edge, stamped by the kernel, less the filter's
//         delay. temperature(): of the chip.
// Frames  B: the chip's axes.
// Units   rad/s, m/s^2, ns, degrees Celsius.
// Errors  kFull: samples were lost before this one, which is good. kBusFault: there is no IMU, as
//         GoneDevice has it; DeviceNews says why, once, and every kRetry_ns it is looked for again.
// Cost    ~1 ms of the bus and three system calls a sample, on the IMU's thread.
// Source  bsp/drivers/icm20602/icm20602.h; bsp/linux/pins.h.
#pragma once

#include <pthread.h>

#include <atomic>
#include <optional>

#include "bsp/api/imu.h"
#include "bsp/drivers/icm20602/icm20602.h"
#include "bsp/linux/device_news.h"
#include "bsp/linux/pins.h"
#include "core/base/counter.h"
#include "core/store/ring.h"

namespace pirvs::bsp {

struct I2cImuSetup {
  const char* device = "";  // for news: icm20602:1
  const char* data_ready = "";
  int bus = 1;
  uint8_t address = 0x68;
  TimeNs delay_ns = 0;  // of the chip's filter
  bool urgent = false;  // SCHED_FIFO
};

struct I2cImuCounters {
  Counter samples, lost, guessed, rejected, edges_lost, bus_errors, silent, resets, opened,
      unplugged;
};
inline constexpr CounterRow<I2cImuCounters> kI2cImuCounterRows[] = {
    {"samples", &I2cImuCounters::samples},
    {"lost", &I2cImuCounters::lost},          // the chip's FIFO ran over, or we were too slow
    {"guessed", &I2cImuCounters::guessed},    // stamps from a neighbour's: their edge was missed
    {"rejected", &I2cImuCounters::rejected},  // packets that were none
    {"edges_lost", &I2cImuCounters::edges_lost},
    {"bus_errors", &I2cImuCounters::bus_errors},
    {"silent", &I2cImuCounters::silent},  // no data-ready edge: set up anew
    {"resets", &I2cImuCounters::resets},  // the chip had lost its set-up
    {"opened", &I2cImuCounters::opened},
    {"unplugged", &I2cImuCounters::unplugged},
};
static_assert(every_counter_is_in(kI2cImuCounterRows));

class I2cImu {
 public:
  static constexpr TimeNs kRetry_ns = 200'000'000;
  static constexpr int kPriority = 42;   // above the stack, below the kernel's interrupt threads
  static constexpr int kErrorsMax = 10;  // in a row, until it is gone

  ~I2cImu() { close(); }

  // The setup's texts must outlive this.
  void configure(const I2cImuSetup& setup, const DeviceNews& news);
  Status poll(ImuSample& out);
  Status temperature(float& degrees_C) const;
  void close();

  int fd() const { return event_fd_; }  // readable when there are samples; -1: not started
  const I2cImuCounters& counters() const { return counters_; }

 private:
  struct Sampled {
    ImuSample sample;
    bool after_loss = false;
  };

  bool start();
  void run();
  const char* open();
  bool serve();
  bool step();
  bool recover(Status status);
  void hand_over();
  void tell(const char* what) { teller_.tell(setup_.device, what); }

  I2cImuSetup setup_;
  DeviceTeller teller_;
  GoneDevice gone_;
  I2cImuCounters counters_;
  pthread_t thread_{};
  bool started_ = false;
  std::atomic<bool> stop_{false}, here_{false};
  int event_fd_ = -1;
  Ring<Sampled, 64> samples_;
  // The thread's own.
  EdgePins data_ready_;
  const char* not_found_ = nullptr;  // why; it is looked for once, before the run
  std::optional<Icm20602> chip_;
  Icm20602::Counters told_;
  int errors_in_row_ = 0;
  bool edges_come_ = false;  // since it was set up
  std::atomic<float> temperature_C_{0};
  std::atomic<bool> temperature_known_{false};
};

}  // namespace pirvs::bsp
