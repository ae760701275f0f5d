#include "board/linux/wiring.h"

#include "bsp/api/clock.h"
#include "bsp/api/tick.h"
#include "bsp/linux/events.h"
#include "bsp/linux/i2c_dev.h"
#include "bsp/linux/pin_trigger.h"
#include "bsp/linux/pwm_trigger.h"

namespace pirvs {
namespace {

bsp::V4l2Stereo stereo;
bsp::IioImu iio;
bsp::I2cImu i2c_imu;
bsp::I2cDev i2c;
Status i2c_answer = Status::kStale;  // of the one transfer under way
bool imu_is_on_i2c = false;
bsp::PwmTrigger pwm_trigger;
bsp::PinTrigger pin_trigger;
bool pin_triggers = false;
TimeNs next_tick = 0;
int door_core = 0;
void (*frame_taken)(const StereoFrame&) = nullptr;

// One descriptor that may end the wait of the door's core.
class Waited {
 public:
  void set(int fd) {
    if (fd == fd_) return;
    if (fd_ >= 0) bsp::forget_fd(door_core, fd_);
    fd_ = fd >= 0 && bsp::watch_fd(door_core, fd) == Status::kOk ? fd : -1;
  }

 private:
  int fd_ = -1;
};
Waited camera_waited[kCamerasMax], imu_waited;

// The frame from which the trigger counts: its image of one camera.
struct Newest {
  TimeNs t = 0;
  int camera = -1;  // none yet
  uint32_t sequence = 0;
} newest;

void centre_trigger() {
  if (!pin_trigger.runs() || newest.camera < 0) return;
  TimeNs exposure_ns[bsp::PinTrigger::kAhead];
  uint32_t sequence = newest.sequence;
  for (TimeNs& of_image : exposure_ns) {
    of_image = stereo.node(newest.camera).exposure_of(++sequence);
  }
  pin_trigger.centre(newest.t, exposure_ns);
}

}  // namespace

void board::wire_sensors(const SensorSetup& setup) {
  door_core = setup.core;
  frame_taken = setup.frame_taken;
  stereo.configure(setup.stereo, setup.news);
  imu_is_on_i2c = setup.imu_is_on_i2c;
  if (imu_is_on_i2c) {
    i2c_imu.configure(setup.i2c_imu, setup.news);
  } else {
    iio.configure(setup.iio, setup.news);
  }
}

const char* board::start_trigger(const TriggerSetup& setup) {
  pin_triggers = setup.pin[0] != 0;
  if (pin_triggers) {
    pin_trigger.configure(setup.pin, setup.urgent);
  } else if (setup.pwm_chip >= 0) {
    pwm_trigger.configure(setup.pwm_chip, setup.pwm_channel);
  } else {
    return nullptr;
  }
  if (bsp::trigger_start(0, setup.timing).ok()) return nullptr;
  return pin_triggers ? pin_trigger.why() : pwm_trigger.why();
}

void board::unwire_sensors() {
  (void)bsp::trigger_stop(0);
  for (Waited& waited : camera_waited) waited.set(-1);
  imu_waited.set(-1);
  stereo.close();
  i2c_imu.close();
  iio.close();
  i2c.close();
}

void board::for_each_sensor_counter(VisitCounter visit) {
  constexpr const char* kCameras[kCamerasMax] = {"camera.left", "camera.right"};
  for (int c = 0; c < kCamerasMax; ++c) {
    for_each_counter(stereo.node(c).counters(), bsp::kV4l2CounterRows,
                     [&](const char* name, uint32_t value) { visit(kCameras[c], name, value); });
  }
  for_each_counter(stereo.counters(), bsp::kStereoCounterRows,
                   [&](const char* name, uint32_t value) { visit("cameras", name, value); });
  const auto of_imu = [&](const char* name, uint32_t value) { visit("imu", name, value); };
  if (imu_is_on_i2c) {
    for_each_counter(i2c_imu.counters(), bsp::kI2cImuCounterRows, of_imu);
  } else {
    for_each_counter(iio.counters(), bsp::kIioCounterRows, of_imu);
  }
  visit("trigger", "pulses", pin_trigger.pulses());
  visit("trigger", "late", pin_trigger.late());
  visit("trigger", "left_out", pin_trigger.left_out());
}

namespace bsp {

Status imu_poll(ImuSample& out) {
  const Status status = imu_is_on_i2c ? i2c_imu.poll(out) : iio.poll(out);
  const int fd = imu_is_on_i2c ? i2c_imu.fd() : iio.fd();
  imu_waited.set(status == Status::kEmpty ? fd : -1);
  return status;
}

Status imu_temperature(float& degrees_C) {
  return imu_is_on_i2c ? i2c_imu.temperature(degrees_C) : Status::kNotFound;
}

// The IMU's thread alone asks. A transfer sleeps, and is done when it has started.
Status i2c_start(int bus, const I2cTransfer& transfer) {
  i2c_answer = i2c.transfer(bus, transfer);
  return Status::kOk;
}

Status i2c_poll(int) {
  const Status answer = i2c_answer;
  i2c_answer = Status::kStale;
  return answer;
}

Status camera_poll(StereoFrame& out) {
  const Status status = stereo.poll(out);
  for (int c = 0; c < kCamerasMax; ++c) {
    camera_waited[c].set(status == Status::kEmpty ? stereo.fd_to_wait_for(c) : -1);
  }
  if (status != Status::kOk) return status;
  const int camera = (out.present & 1) != 0 ? 0 : 1;
  newest = {out.t, camera, out.info[camera].sequence};
  centre_trigger();
  if (frame_taken != nullptr) frame_taken(out);
  return status;
}

void camera_retain(FrameId id) { stereo.retain(id); }

void camera_release(FrameId id) { stereo.release(id); }

Result<CameraRange> camera_range() { return stereo.range(); }

Status camera_control(const CameraControl& control) {
  const Status status = stereo.control(control);
  centre_trigger();
  return status;
}

Result<TriggerStart> trigger_start(int output, const TriggerTiming& timing) {
  if (output != 0) return Status::kNotFound;
  return pin_triggers ? pin_trigger.start(timing) : pwm_trigger.start(timing);
}

Status trigger_stop(int output) {
  if (output != 0) return Status::kNotFound;
  return pin_triggers ? pin_trigger.stop() : pwm_trigger.stop();
}

Status tick_poll(TimeNs& out) {
  const TimeNs t = now();
  if (t < next_tick) return Status::kEmpty;
  out = t;
  next_tick = t + kTick_ns;
  return Status::kOk;
}

}  // namespace bsp
}  // namespace pirvs
