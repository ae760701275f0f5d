// A GNSS receiver on a serial line, or by datagrams. It may come and go.
// In      open(): where, and to whom. pulse(): each pulse of SYNC_IN from which a clock is known,
//         from core 0. Then either start_thread(), or poll() again and again from one core.
// Out     Fixes to the sensor door, with stamps on the device's clock; what a stamp may be off by
//         is in the fix's sigmas (widen_by()).
// Units   ns, m, m/s.
// Errors  open, start_thread: nullptr, or why not. A line that is not there, busy, gone or says
//         nothing that is known is told by name, once each, and looked for every kRetry_ns. A fix
//         whose time cannot be, or beyond kRate_hz_max, is dropped and counted.
// Cost    A thread of its own, as urgent as any program and no more, that wakes by its bytes: so
//         that the time of their arrival is true, and nobody waits for it. ~10 us a fix. No heap.
// Source  docs/gnss.md.
#pragma once

#include <pthread.h>

#include <atomic>

#include "board/linux/gnss_settings.h"
#include "bsp/drivers/pps/pps.h"
#include "bsp/linux/device_news.h"
#include "core/store/ring.h"
#include "modules/door/arrival.h"
#include "modules/gnss/receiver_reader.h"

namespace pirvs::board {

struct GnssCounters {
  Counter opened, bytes, fixes, by_pulse, without_time, odd, flood, not_delivered, sigma_us;
};
inline constexpr CounterRow<GnssCounters> kGnssCounterRows[] = {
    {"opened", &GnssCounters::opened},  // it came
    {"bytes", &GnssCounters::bytes},
    {"fixes", &GnssCounters::fixes},                // delivered
    {"by_pulse", &GnssCounters::by_pulse},          // of them with the stamps of its pulse
    {"without_time", &GnssCounters::without_time},  // of them stamped as they came
    {"odd", &GnssCounters::odd},                    // their time cannot be, or does not go on
    {"flood", &GnssCounters::flood},                // more than a receiver sends
    {"not_delivered", &GnssCounters::not_delivered},
    {"sigma_us", &GnssCounters::sigma_us},  // of the newest stamp, no count
};
static_assert(every_counter_is_in(kGnssCounterRows));

// To whom.
struct GnssSinks {
  void* context = nullptr;
  Status (*deliver)(void*, const Arrival&) = nullptr;
  TimeNs (*now)() = nullptr;  // the clock of the sensors' stamps
  bsp::DeviceNews news;       // from the thread
};

// What a fix is off by whose stamp is off by sigma_ns: its velocity times that.
void widen_by(double sigma_ns, GnssFix& fix);

class GnssReceiver {
 public:
  static constexpr TimeNs kRetry_ns = 500'000'000;
  static constexpr TimeNs kSilent_ns = 5'000'000'000;  // nothing, or nothing known, is told then
  static constexpr int kRate_hz_max = 50;

  ~GnssReceiver() { close(); }

  const char* open(const GnssSettings& settings, const GnssSinks& sinks);
  const char* start_thread();
  void close();

  void pulse(const bsp::Pps& pps);
  void poll();

  template <class Visit>
  void for_each_counter(Visit&& visit) const {
    pirvs::for_each_counter(counters_, kGnssCounterRows, visit);
    pirvs::for_each_counter(reader_.ubx(), kUbxCounters, visit);
    pirvs::for_each_counter(reader_.nmea(), kNmeaCounters, visit);
  }
  const GnssCounters& counters() const { return counters_; }

 private:
  static constexpr size_t kBytesAtOnce = 4096;  // 10 ms of the fastest line
  static constexpr size_t kPulsesMax = 4;

  const char* device() const { return settings_.has_udp ? "gnss" : settings_.serial.text; }
  void look_for_it(TimeNs now);
  void lose(const char* why);
  const char* open_line();
  size_t receive(uint8_t* bytes, size_t max);
  void take_bytes(const uint8_t* bytes, size_t size, TimeNs now);
  void take(const ReceiverFix& read, TimeNs arrival);
  bool is_flood(TimeNs now);
  void judge_silence(TimeNs now);
  void run();

  GnssSettings settings_;
  GnssSinks sinks_;
  bsp::DeviceTeller news_;
  int fd_ = -1;  // of the line or the socket
  bool has_socket_ = false;
  bsp::Socket socket_;
  TimeNs retry_t_ = INT64_MIN;
  TimeNs byte_t_ = INT64_MIN, fix_t_ = INT64_MIN;  // when the last one came, or the line
  TimeNs burst_t_ = INT64_MIN;  // when the bytes began that no silence parts; none: it had a fix
  ReceiverReader reader_;
  ReceiverClock clock_;
  TimeNs stamp_t_ = INT64_MIN;  // of the last fix
  int credit_ = kRate_hz_max;   // fixes
  TimeNs credit_t_ = 0;
  Ring<ReceiverSecond, kPulsesMax> pulses_;
  pthread_t thread_{};
  bool runs_ = false;
  std::atomic<bool> stop_{false};
  GnssCounters counters_;
};

}  // namespace pirvs::board
