#include "bsp/replay/sensors.h"

#include "bsp/api/tick.h"

namespace pirvs::bsp {
namespace {

Replay replay;

}  // namespace

void play(const RecordingSource& source, ReplayPace pace) { replay.start(source, pace); }

TimeNs replay_now() { return replay.sensor_now(); }

Status imu_poll(ImuSample& out) { return replay.poll(out); }

Status imu_temperature(float&) { return Status::kNotFound; }

Status camera_poll(StereoFrame& out) { return replay.poll(out); }

void camera_retain(FrameId id) { replay.retain(id); }

void camera_release(FrameId id) { replay.release(id); }

Status tick_poll(TimeNs& out) { return replay.poll_tick(out); }

Result<CameraRange> camera_range() { return replay.range(); }

Status camera_control(const CameraControl& control) { return replay.control(control); }

}  // namespace pirvs::bsp
