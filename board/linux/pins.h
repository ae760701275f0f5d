// Inputs and outputs of the device's header pins, by the roles that the configuration assigns.
//   HEALTH     high while tracking is good; low in the frame that is not, and when none comes
//   SYNC_OUT   a pulse at the middle of each exposure
//   SYNC_IN    an event, given out with the pose at its time; or a pulse per second
//   wheels     an encoder's two pins A and B, left and right: ticks 50 times a second
// In      open(): before the run. frame_taken(): each frame, as soon as it is there. pose(): each
//         of the feed. health(): its changes. poll(): as often as core 0 comes round. All from core
//         0, which runs the door.
// Out     Edges and wheel samples to App::deliver, so that a recording holds them. SyncEvent: an
//         edge of SYNC_IN and the pose at its time.
// Units   ns on CLOCK_MONOTONIC.
// Errors  open: a pin that cannot be had is told by name and is left out. All else is counted.
// Cost    SYNC_IN: a system call when the wait of core 0 ended by an edge, one a pose, so that no
//         edge misses the one after it, and one every kLook_ns; wheels: one a pin every kLook_ns.
// Source  bsp/linux/pins.h; docs/device.md, "Pins".
#pragma once

#include "board/linux/exposure_clock.h"
#include "board/linux/settings.h"
#include "bsp/drivers/pps/pps.h"
#include "bsp/drivers/quadrature/quadrature.h"
#include "bsp/linux/device_news.h"
#include "bsp/linux/pulse_thread.h"
#include "core/store/ring.h"
#include "modules/door/arrival.h"
#include "modules/output/pose_feed.h"

namespace pirvs::board {

struct SyncEvent {
  bsp::GpioEdge edge;
  bool has_pose = false;  // false: nobody tracked at its time
  Pose pose;              // at edge.t
};

struct PinSinks {
  void* context = nullptr;
  Status (*deliver)(void*, const Arrival&) = nullptr;
  void (*event)(void*, const SyncEvent&) = nullptr;
  void (*pps)(void*, const bsp::Pps&) = nullptr;  // each pulse from which a clock is known
};

struct PinCounters {
  Counter sync_in_edges, sync_in_lost, sync_in_late, pps_odd, wheel_edges, wheel_lost, wheel_missed,
      not_delivered, health_falls;
};
inline constexpr CounterRow<PinCounters> kPinCounterRows[] = {
    {"sync_in_edges", &PinCounters::sync_in_edges},
    {"sync_in_lost", &PinCounters::sync_in_lost},  // by the kernel's count
    {"sync_in_late", &PinCounters::sync_in_late},  // events given out without a pose
    {"pps_odd", &PinCounters::pps_odd},            // pulses that are no second
    {"wheel_edges", &PinCounters::wheel_edges},
    {"wheel_lost", &PinCounters::wheel_lost},      // by the kernel's count
    {"wheel_missed", &PinCounters::wheel_missed},  // an edge without its partner
    {"not_delivered", &PinCounters::not_delivered},
    {"health_falls", &PinCounters::health_falls},
};
static_assert(every_counter_is_in(kPinCounterRows));

class Pins {
 public:
  void open(const PinSettings& settings, bool urgent, const bsp::DeviceNews& news,
            const PinSinks& sinks);
  void close();

  void frame_taken(TimeNs t);
  void pose(const Pose& pose);
  void health(HealthState state);
  void poll();

  const PinCounters& counters() const { return counters_; }
  const bsp::Pps& pps() const { return pps_; }
  uint32_t pulses() const { return sync_out_.pulses(); }
  uint32_t pulses_left_out() const { return sync_out_.left_out(); }
  int sync_in_fd() const { return sync_in_.fd(); }  // -1: there is none

 private:
  static constexpr TimeNs kWheelPeriod_ns = 20'000'000;
  static constexpr TimeNs kLook_ns = 10'000'000;  // the kernel keeps 51 ms of an encoder's 20 kHz
  static constexpr TimeNs kNoPose_ns = 100'000'000;  // an event waits so long for the pose after it
  static constexpr int kEventsMax = 32;

  struct Wheel {
    bsp::EdgePins pins;
    bsp::Quadrature encoder;
    uint32_t missed_told = 0;
  };

  void tell_failure(const char* pin, const char* why);
  void set_health(bool good);
  void judge_health(const Pose& pose);
  void read_sync_in();
  void take_pps(TimeNs t);
  void poll_wheels();
  void give_events(const Pose* pose);
  void deliver(const Arrival& arrival);

  PinSettings settings_;
  bsp::DeviceNews news_;
  PinSinks sinks_;
  PinCounters counters_;

  bsp::OutputPin health_pin_;
  bool healthy_ = false;
  TimeNs fused_t_ = 0;      // of the newest frame that a pose stands on
  TimeNs fused_due_t_ = 0;  // by when the next one must be there

  bsp::OutputPin sync_out_pin_;
  ExposureClock exposures_;
  bsp::PulseThread sync_out_;

  bsp::EdgePins sync_in_;
  TimeNs look_t_ = 0;  // for its edges, at the latest
  bsp::Pps pps_;
  Ring<bsp::GpioEdge, kEventsMax> events_;
  Pose last_pose_;
  bool has_last_pose_ = false;

  Wheel wheels_[2];
  bool any_wheel_ = false;
  TimeNs wheel_look_t_ = 0, wheel_t_ = 0;  // of the next look, and sample
};

}  // namespace pirvs::board
