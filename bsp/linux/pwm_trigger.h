// Trigger pulses by a PWM of the kernel, through sysfs.
// In      configure(): chip and channel of /sys/class/pwm. start(), stop(): as trigger_start and
//         trigger_stop (bsp/api/trigger.h).
// Out     The period and width that the driver was given; hardware rounds them to ticks of its
//         clock (RK3399: 41.7 ns) and sysfs does not tell how. first_t: the middle of the system
//         call that starts the output, error_ns half its length: user space cannot do better. A
//         phase is kept no better than that, and drifts as the PWM's clock does against now().
// Errors  kNotFound: no such chip or channel. kBusFault: no permission, or the driver refuses; see
//         why(). kBadData: width or phase not below the period, or no pulse.
// Cost    start: eight files, and the wait for the phase. Not for a step.
// Source  Linux, Documentation/driver-api/pwm.rst, "Using PWMs with the sysfs interface".
#pragma once

#include "bsp/api/trigger.h"
#include "core/base/text.h"

namespace pirvs::bsp {

class PwmTrigger {
 public:
  // root: before /sys; tests give a folder.
  void configure(int chip, int channel, const char* root = "");
  Result<TriggerStart> start(const TriggerTiming& timing);
  Status stop();
  const char* why() const { return why_; }  // the last failure, for a person

 private:
  using Path = Text<160>;

  Status fail(Status status, const char* why);
  void put_chip(Path& path) const;
  bool set(const char* file, const char* text);
  bool set(const char* file, uint32_t value);
  Status export_channel();

  const char* root_ = "";
  int chip_ = 0, channel_ = 0;
  bool exported_ = false;  // by us
  bool running_ = false;
  const char* why_ = "";
};

}  // namespace pirvs::bsp
