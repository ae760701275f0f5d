#include "board/linux/wiring.h"

#include "bsp/api/clock.h"
#include "bsp/api/tick.h"
#include "bsp/linux/events.h"

namespace pirvs {
namespace {

bsp::V4l2Stereo stereo;
bsp::IioImu imu;
TimeNs next_tick = 0;
int door_core = 0;
void (*on_frame)(const StereoFrame&) = nullptr;

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

}  // namespace

void board::wire_sensors(const SensorSetup& setup) {
  door_core = setup.core;
  on_frame = setup.frame;
  stereo.configure(setup.stereo, setup.news);
  imu.configure(setup.imu, setup.news);
}

void board::unwire_sensors() {
  for (Waited& waited : camera_waited) waited.set(-1);
  imu_waited.set(-1);
  stereo.close();
  imu.close();
}

void board::for_each_sensor_counter(VisitCounter visit) {
  constexpr const char* kCameras[kCamerasMax] = {"camera.left", "camera.right"};
  for (int c = 0; c < kCamerasMax; ++c) {
    for_each_counter(stereo.node(c).counters(), bsp::kV4l2CounterRows,
                     [&](const char* name, uint32_t value) { visit(kCameras[c], name, value); });
  }
  for_each_counter(stereo.counters(), bsp::kStereoCounterRows,
                   [&](const char* name, uint32_t value) { visit("cameras", name, value); });
  for_each_counter(imu.counters(), bsp::kIioCounterRows,
                   [&](const char* name, uint32_t value) { visit("imu", name, value); });
}

namespace bsp {

Status imu_poll(ImuSample& out) {
  const Status status = imu.poll(out);
  imu_waited.set(status == Status::kEmpty ? imu.fd() : -1);
  return status;
}

Status imu_temperature(float&) { return Status::kNotFound; }

Status camera_poll(StereoFrame& out) {
  const Status status = stereo.poll(out);
  if (status == Status::kOk && on_frame != nullptr) on_frame(out);
  for (int c = 0; c < kCamerasMax; ++c) {
    camera_waited[c].set(status == Status::kEmpty ? stereo.fd_to_wait_for(c) : -1);
  }
  return status;
}

void camera_retain(FrameId id) { stereo.retain(id); }

void camera_release(FrameId id) { stereo.release(id); }

Status camera_control(const CameraControl&) { return Status::kNotFound; }

Status tick_poll(TimeNs& out) {
  const TimeNs t = now();
  if (t < next_tick) return Status::kEmpty;
  out = t;
  next_tick = t + kTick_ns;
  return Status::kOk;
}

}  // namespace bsp
}  // namespace pirvs
