// The device's datagrams to whoever asks for them: modules/stream/stream.h.
// In      open(): where to listen, and the stack. All others from core 0: pose(), health(),
//         event(), pps(), fused(), imu() and frame() as they come, poll() as often as core 0 comes
//         round.
// Out     To each subscriber the kinds that it asked for, until its lease ends; poses and events as
//         they come, counters once a second, points and thumbnails twice.
// Errors  open: nullptr, or why not. More than kSubscribersMax: refused and counted. Datagrams that
//         are no requests, or have no room on their way: counted.
// Cost    A pose ~5 us a subscriber, its system call. Nothing is made that nobody wants. Requests
//         are looked for when the wait of core 0 ended by them, and every kLook_ns.
// Source  docs/device.md, "Stream".
#pragma once

#include "board/linux/pins.h"
#include "modules/app/app.h"
#include "modules/stream/stream.h"

namespace pirvs::board {

struct StreamCounters {
  Counter sent, dropped, bad_requests, refused;
};
inline constexpr CounterRow<StreamCounters> kStreamCounterRows[] = {
    {"sent", &StreamCounters::sent},
    {"dropped", &StreamCounters::dropped},  // no room on their way
    {"bad_requests", &StreamCounters::bad_requests},
    {"refused", &StreamCounters::refused},  // more subscribers than there may be
};
static_assert(every_counter_is_in(kStreamCounterRows));

// Every counter of the device by name.
using VisitValue = void (*)(void* context, const char* name, uint64_t value);

class StreamOutput {
 public:
  static constexpr int kSubscribersMax = 4;
  static constexpr int kLeaseMax_s = 60;
  static constexpr TimeNs kLook_ns = 10'000'000;

  const char* open(bsp::Endpoint own, const App& app,
                   void (*for_each_counter)(VisitValue, void* context));
  void close();

  void pose(const Pose& pose);
  void health(TimeNs t, HealthState state, const char* why);
  void event(const SyncEvent& event);
  void pps(const bsp::Pps& pps);
  void fused(const FusedPose& pose);
  void imu(const ImuSample& sample);
  void frame(const StereoFrame& frame);
  void poll();

  bool is_open() const { return open_; }
  Result<uint16_t> port() const { return bsp::datagram_port(socket_); }
  const StreamCounters& counters() const { return counters_; }

 private:
  struct Subscriber {
    bsp::Endpoint to;
    uint32_t kinds = 0;
    TimeNs until_t = 0;  // of the lease; 0: nobody
    uint32_t sequence = 0;
  };

  void take_requests();
  void subscribe(const bsp::Endpoint& from, const stream::SubscribeMessage& message);
  bool anybody_wants(stream::Kind kind) const;
  void send(Subscriber& subscriber, size_t size);
  template <class Encode>
  void send_all(stream::Kind kind, Encode encode);
  void send_counters();
  void send_points();

  const App* app_ = nullptr;
  void (*for_each_counter_)(VisitValue, void*) = nullptr;
  bool open_ = false;
  bsp::Socket socket_;
  Subscriber subscribers_[kSubscribersMax];
  TimeNs now_ = 0;                                          // of the last poll
  TimeNs look_t_ = 0;                                       // for requests, at the latest
  TimeNs counters_t_ = 0, points_t_ = 0, thumbnail_t_ = 0;  // of the next ones
  StreamCounters counters_;
  uint8_t bytes_[stream::kMax];
};

}  // namespace pirvs::board
