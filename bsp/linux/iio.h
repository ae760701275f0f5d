// The IMU by the kernel's IIO: set up by sysfs, samples read raw from /dev/iio:deviceN.
// In      configure(), then poll(), close(): from one core.
// Out     poll: as imu_poll. t: the kernel's stamp on CLOCK_MONOTONIC, less the filter's delay.
//         Scale, offset, mount matrix and layout of a sample are the driver's own words.
// Frames  B: IMU body, after the mount matrix (row by row, as the kernel documents it).
// Units   rad/s, m/s^2, ns.
// Errors  kFull: samples were lost before this one, by their stamps; it is good. kBadData: stamps
//         are of another clock, the sample is dropped. kBusFault: there is no IMU, as GoneDevice
//         has it; DeviceNews says why, once, and every kRetry_ns it is looked for again.
//         What was set (clock, rate, elements, length, watermark) is as before after close().
// Cost    One read for up to kSamples samples. No library.
// Source  kernel, Documentation/ABI/testing/sysfs-bus-iio; iio/iio_devbuf.rst.
#pragma once

#include "bsp/api/imu.h"
#include "bsp/linux/device_news.h"
#include "core/base/counter.h"

namespace pirvs::bsp {

struct IioSetup {
  const char* root = "";         // before /sys and /dev; tests give a folder
  const char* device = "iio:0";  // by number, or by the name that its driver gives: iio:mpu6500
  double rate_hz = 200;          // the next one that the driver offers counts
  TimeNs delay_ns = 0;           // of the chip's filter
};

struct IioCounters {
  Counter samples, lost, wrong_clock, opened, unplugged;
};
inline constexpr CounterRow<IioCounters> kIioCounterRows[] = {
    {"samples", &IioCounters::samples},         {"lost", &IioCounters::lost},  // by their stamps
    {"wrong_clock", &IioCounters::wrong_clock}, {"opened", &IioCounters::opened},
    {"unplugged", &IioCounters::unplugged},
};
static_assert(every_counter_is_in(kIioCounterRows));

// Where a channel lies within a sample, and what it means: "le:s16/16>>0".
struct IioElement {
  int index = 0;   // order among the enabled ones
  int offset = 0;  // bytes
  int bytes = 0, bits = 0, shift = 0;
  bool is_signed = false, big_endian = false;
};
[[nodiscard]] bool read_element_type(const char* text, IioElement& out);
int64_t read_element(const IioElement& element, const uint8_t* sample);

class IioImu {
 public:
  static constexpr TimeNs kRetry_ns = 200'000'000;
  static constexpr int kSamples = 32;  // read at once

  // The setup's texts must outlive this.
  void configure(const IioSetup& setup, const DeviceNews& news);
  ~IioImu() { close(); }

  Status poll(ImuSample& out);
  void close();

  bool is_open() const { return fd_ >= 0; }
  int fd() const { return fd_; }  // -1: none; it changes whenever the IMU comes and goes
  double rate_hz() const { return rate_hz_; }
  const IioCounters& counters() const { return counters_; }

 private:
  static constexpr int kChannels = 7;  // force, rate, time
  static constexpr int kTime = 6;
  static constexpr int kSampleMax = 128;
  static constexpr int kPathMax = 192;
  static constexpr int kSavedMax = 32;

  // A file of sysfs as it was.
  struct Saved {
    char path[kPathMax];
    char text[32];
  };

  Status look_for_imu();
  bool find_device();
  const char* open_imu();
  const char* open_node();
  const char* set_clock_and_rate();
  const char* set_elements();
  const char* lay_out();
  const char* read_meaning();
  const char* start();
  bool path_of(const char* file, char* out) const;
  bool read_file(const char* file, char* out, int max) const;
  bool set_file(const char* file, const char* text);
  bool read_mount(const char* file, Mat3& out) const;
  Status refill();
  Status decode(const uint8_t* bytes, ImuSample& out);
  void gone();

  IioSetup setup_;
  DeviceTeller teller_;
  GoneDevice gone_;
  IioCounters counters_;
  int fd_ = -1;
  int number_ = 0;
  TimeNs retry_t_ = 0;
  double rate_hz_ = 0;
  double accel_scale_ = 0, gyro_scale_ = 0;
  Mat3 R_accel_ = Mat3::Identity(), R_gyro_ = Mat3::Identity();
  IioElement elements_[kChannels];
  int sample_bytes_ = 0;
  Saved saved_[kSavedMax];
  int saved_count_ = 0;
  alignas(8) uint8_t bytes_[kSamples * kSampleMax];
  int bytes_here_ = 0, bytes_at_ = 0;
  TimeNs last_t_ = 0;
  bool has_last_ = false;
};

}  // namespace pirvs::bsp
