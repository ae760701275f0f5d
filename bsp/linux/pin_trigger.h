// Trigger pulses on a pin, early by half an exposure: the middle of each exposure stays on a grid
// of time, however auto-exposure changes its length.
// In      configure(): the pin, by a name as bsp/linux/pins.h has it. start(), stop(): as
//         trigger_start and trigger_stop (bsp/api/trigger.h). centre(): from one core, when a frame
//         came and when exposures were commanded: the middle of the newest frame, and how long the
//         images after it are exposed, the next one first.
// Out     The grid's points are phase_ns past the multiples of the period on now(): no error adds
//         up. Before the first centre() and while exposures are unknown (0), a pulse begins at its
//         point.
// Units   ns on CLOCK_MONOTONIC.
// Errors  start: kBadData: no pulse, or more than half a period of it. kBusFault: the pin cannot be
//         had, or there is no thread; see why(). late(), left_out(): as PulseThread counts them.
// Cost    centre: ~50 ns. The thread's: bsp/linux/pulse_thread.h.
// Source  A sensor that is triggered begins to expose at the pulse.
#pragma once

#include "bsp/api/trigger.h"
#include "bsp/linux/pulse_thread.h"

namespace pirvs::bsp {

class PinTrigger {
 public:
  static constexpr int kAhead = PulsePlan::kLeads - 1;  // images whose exposures centre() is told

  // urgent: SCHED_FIFO. The text must outlive this.
  void configure(const char* pin, bool urgent);
  Result<TriggerStart> start(const TriggerTiming& timing);
  void centre(TimeNs t, const TimeNs (&exposure_ns)[kAhead]);
  Status stop();

  bool runs() const { return plan_.period_ns > 0; }
  uint32_t pulses() const { return thread_.pulses(); }
  uint32_t late() const { return thread_.late(); }
  uint32_t left_out() const { return thread_.left_out(); }
  const char* why() const { return why_; }  // the last failure, for a person

 private:
  Status fail(Status status, const char* why);

  const char* name_ = "";
  bool urgent_ = false;
  OutputPin pin_;
  PulseThread thread_;
  PulsePlan plan_;
  const char* why_ = "";
};

// The plan after a frame: its point of the grid is the first one, and each image after it begins
// half its exposure early.
PulsePlan centred(const PulsePlan& plan, TimeNs t, const TimeNs (&exposure_ns)[PinTrigger::kAhead]);

}  // namespace pirvs::bsp
