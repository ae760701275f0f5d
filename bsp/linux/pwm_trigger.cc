#include "bsp/linux/pwm_trigger.h"

#include <errno.h>
#include <unistd.h>

#include <cstring>

#include "bsp/api/clock.h"
#include "bsp/linux/clock.h"
#include "bsp/linux/sysfs.h"

namespace pirvs::bsp {
namespace {

constexpr size_t kNumberMax = 32;

}  // namespace

void PwmTrigger::configure(int chip, int channel, const char* root) {
  *this = PwmTrigger{};
  chip_ = chip;
  channel_ = channel;
  root_ = root;
}

Status PwmTrigger::fail(Status status, const char* why) {
  why_ = why;
  return status;
}

void PwmTrigger::put_chip(Path& path) const {
  path.put(root_).put("/sys/class/pwm/pwmchip").number(chip_);
}

bool PwmTrigger::set(const char* file, const char* text) {
  Path path;
  put_chip(path);
  path.put("/pwm").number(channel_).put('/').put(file);
  return write_file(path.c_str(), text);
}

bool PwmTrigger::set(const char* file, uint32_t value) {
  Text<kNumberMax> text;
  text.unsigned_number(value);
  return set(file, text.c_str());
}

// One that another program has exported is used, and left exported.
Status PwmTrigger::export_channel() {
  Path folder, path;
  put_chip(folder);
  if (access(folder.c_str(), F_OK) != 0) return fail(Status::kNotFound, "no such PWM chip");
  put_chip(path);
  path.put("/pwm").number(channel_);
  if (access(path.c_str(), F_OK) == 0) return Status::kOk;
  folder.put("/export");
  Text<kNumberMax> number;
  number.number(channel_);
  if (!write_file(folder.c_str(), number.c_str())) {
    if (errno == EBUSY) return fail(Status::kBusFault, "the kernel itself uses this PWM");
    if (errno == EACCES) return fail(Status::kBusFault, "no permission to export a PWM");
    return fail(Status::kNotFound, "no such channel of this PWM chip");
  }
  exported_ = true;
  return Status::kOk;
}

Result<TriggerStart> PwmTrigger::start(const TriggerTiming& timing) {
  const bool possible = timing.width_ns > 0 && timing.width_ns < timing.period_ns &&
                        timing.phase_ns < timing.period_ns;
  if (!possible) return fail(Status::kBadData, "width and phase must be below the period");
  PIRVS_TRY(export_channel());
  // Off first, then from large to small: a width never exceeds its period on the way.
  (void)set("enable", "0");
  (void)set("duty_cycle", "0");
  if (!set("period", timing.period_ns) || !set("duty_cycle", timing.width_ns)) {
    return fail(Status::kBusFault, "the PWM refuses this rate or width");
  }
  if (!set("polarity", timing.active_low ? "inversed" : "normal") && timing.active_low) {
    return fail(Status::kBusFault, "the PWM cannot be active low");
  }
  const TimeNs period = timing.period_ns;
  const TimeNs wait = period - (now() - timing.phase_ns) % period;
  sleep_until(now() + wait);
  TriggerStart out;
  const TimeNs before = now();
  if (!set("enable", "1")) return fail(Status::kBusFault, "the PWM cannot be enabled");
  const TimeNs after = now();
  running_ = true;
  out.first_t = before + (after - before) / 2;
  out.error_ns = (after - before + 1) / 2;
  out.period_ns = static_cast<double>(period);
  return out;
}

Status PwmTrigger::stop() {
  const bool stopped = !running_ || set("enable", "0");
  running_ = false;
  if (exported_) {
    Path path;
    put_chip(path);
    path.put("/unexport");
    Text<kNumberMax> number;
    number.number(channel_);
    (void)write_file(path.c_str(), number.c_str());
    exported_ = false;
  }
  return stopped ? Status::kOk : fail(Status::kBusFault, "the PWM cannot be stopped");
}

}  // namespace pirvs::bsp
