// What App does when it is told to.
#include "bsp/api/cores.h"
#include "bsp/api/events.h"
#include "modules/app/app.h"

namespace pirvs {

// The door's core, which calls poll(), is core 0 in every plan.
Result<uint32_t> App::command(const Command& command) {
  const Result<uint32_t> ticket = commands_.push(command);
  bsp::wake(0);
  return ticket;
}

Status App::record() {
  const Status status = recorder_.start(calibration_.camera, calibration_.cameras, calibration_.imu,
                                        calibration_.camera_time_offset_ns);
  if (status != Status::kOk) {
    recorder_.finish();
    return status;
  }
  const auto arrival = [](void* r, const Arrival& a) { static_cast<Recorder*>(r)->arrival(a); };
  intake_.set_tap({&recorder_, arrival});
  return Status::kOk;
}

Status App::start_recorder_core() {
  recorder_.set_core(plan_.cores);
  const auto entry = [](void* r) { static_cast<Recorder*>(r)->run(); };
  return bsp::start_core(plan_.cores, entry, &recorder_);
}

// True: something was done. A command that has to wait for mapping is asked again. It comes by the
// door, which nothing passes once the sensors have ended.
bool App::command_step() {
  if (ending_ && !has_command_) has_command_ = commands_.pop(executing_);
  if (!has_command_) return false;
  const Status status = execute(executing_);
  if (status == Status::kEmpty) return false;
  has_command_ = false;
  if (sinks_.answer != nullptr) {
    sinks_.answer(sinks_.context, {executing_.ticket, executing_.kind, status});
  }
  return true;
}

// kEmpty: not yet, mapping must come to rest. Until then nothing is taken from the sensors, so
// what a command finds does not depend on how fast mapping is.
Status App::execute(const Command& command) {
  switch (command.kind) {
    case CommandKind::kStop:
      ending_ = true;
      return Status::kOk;
    case CommandKind::kStartRecording:
      return start_recording();
    case CommandKind::kStopRecording:
      return stop_recording();
    default:
      break;
  }
  estimator_.map_gate().open();
  if (!estimator_.mapping_rests()) return Status::kEmpty;
  switch (command.kind) {
    case CommandKind::kReset:
      estimator_.reset(door_t_);
      return Status::kOk;
    default:
      return Status::kNotFound;
  }
}

Status App::start_recording() {
  if (recorder_.started()) return Status::kStale;
  PIRVS_TRY(record());
  return start_recorder_core();
}

Status App::stop_recording() {
  if (!recorder_.started()) return Status::kStale;
  intake_.set_tap({});
  recorder_.stop();
  return Status::kOk;
}

}  // namespace pirvs
