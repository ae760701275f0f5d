// What App does when it is told to.
#include <cstring>

#include "bsp/api/cores.h"
#include "bsp/api/events.h"
#include "bsp/api/storage.h"
#include "core/base/text.h"
#include "core/math/so3.h"
#include "modules/app/app.h"
#include "modules/app/lens_scale.h"
#include "modules/map/map_file.h"

namespace pirvs {
namespace {

Status set_pose(Estimator& estimator, TimeNs t, const Command& command) {
  constexpr double kTurn_rad = 6.3;
  if (!command.p_WB.allFinite() ||
      !(command.yaw_rad >= -kTurn_rad && command.yaw_rad <= kTurn_rad)) {
    return Status::kBadData;
  }
  const auto sigma_m = static_cast<double>(command.value);
  return estimator.set_pose(t, command.p_WB, command.yaw_rad, sigma_m);
}

// Where it is upright, if it is not here.
Status set_node(Estimator& estimator, const Command& command) {
  SE3 T_WN = estimator.tracker().place();
  if (command.value > 0) T_WN = {so3_exp(Vec3(0, 0, command.yaw_rad)), command.p_WB};
  return estimator.set_node(command.text, T_WN);
}

// Written beside the old one and then put in its place: whenever power fails, one of them is whole.
Status save(const Map& map, const char* name, MapIndex& index) {
  Text<Command::kTextMax + 8> part;
  part.put(name).put(".part");
  const Result<bsp::File> opened = bsp::storage_open(part.c_str());
  if (!opened.ok()) return opened.status();
  bsp::File file = opened.value();
  const auto write = [](void* to, const void* data, size_t size) {
    return bsp::storage_write(*static_cast<bsp::File*>(to), data, size);
  };
  Status status = save_map(map, {&file, write}, index);
  if (status == Status::kOk) status = bsp::storage_sync(file);
  const Status closed = bsp::storage_close(file);
  if (status == Status::kOk) status = closed;
  if (status == Status::kOk) return bsp::storage_rename(part.c_str(), name);
  (void)bsp::storage_remove(part.c_str());
  return status;
}

// Read twice: a file that is not whole changes nothing.
Status load(Estimator& estimator, TimeNs t, const char* name) {
  Status status = Status::kOk;
  for (const bool verify : {true, false}) {
    const Result<bsp::File> opened = bsp::storage_open_to_read(name);
    if (!opened.ok()) return opened.status();
    bsp::File file = opened.value();
    const auto read = [](void* from, void* data, size_t size) {
      const Result<size_t> count = bsp::storage_read(*static_cast<bsp::File*>(from), data, size);
      if (!count.ok()) return count.status();
      return count.value() == size ? Status::kOk : Status::kBadData;
    };
    const MapSource source = {&file, read};
    status = verify ? verify_map(source) : estimator.load_map(t, source);
    const Status closed = bsp::storage_close(file);
    if (status == Status::kOk) status = closed;
    if (status != Status::kOk) break;
  }
  return status;
}

}  // namespace

// The door's core, which calls poll(), is core 0 in every plan.
Result<uint32_t> App::command(const Command& command) {
  const Result<uint32_t> ticket = inbox_.push(command);
  bsp::wake(0);
  return ticket;
}

Status App::deliver(const Arrival& arrival) {
  const Status status = inbox_.push(arrival);
  bsp::wake(0);
  return status;
}

Status App::record() {
  if (recorder_.busy()) return Status::kStale;
  Result<const char*> folder = "";
  if (sinks_.new_recording != nullptr) folder = sinks_.new_recording(sinks_.context);
  if (!folder.ok()) return folder.status();
  const Status status = recorder_.start(calibration_, folder.value());
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
  const Status status = bsp::start_core(plan_.cores, entry, &recorder_);
  recorder_core_runs_ = status == Status::kOk;
  return status;
}

// True: something was done. A command that has to wait for mapping is asked again. It comes by the
// door, which nothing passes once the sensors have ended.
bool App::command_step() {
  for (Arrival told; ending_ && !has_command_ && inbox_.pop(told);) {
    executing_ = told.command;
    has_command_ = told.kind == ArrivalKind::kCommand;  // all else comes too late
  }
  if (!has_command_) return false;
  const Status status = execute(executing_);
  if (status == Status::kEmpty) return false;
  has_command_ = false;
  if (sinks_.answer != nullptr) {
    sinks_.answer(sinks_.context, {executing_.ticket, executing_.kind, status, found_});
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
  const uint32_t resets = estimator_.fused().trust.resets;
  const Status status = execute_at_rest(command);
  if (estimator_.fused().trust.resets != resets) output_.replace(estimator_.fused());
  return status;
}

Status App::execute_at_rest(const Command& command) {
  switch (command.kind) {
    case CommandKind::kReset:
      estimator_.reset(door_t_, "reset by command");
      return Status::kOk;
    case CommandKind::kSetParameter:
      return retune(command.text, command.value);
    case CommandKind::kSetPose:
      return set_pose(estimator_, door_t_, command);
    case CommandKind::kSaveMap:
      if (params_.mapping.extend_map < 0.5f) return Status::kStale;  // what is new is not kept
      return save(estimator_.map(), command.text, map_index_);
    case CommandKind::kSetNode:
      return set_node(estimator_, command);
    case CommandKind::kGetNode: {
      const Result<SE3> pose = estimator_.node_pose(command.text);
      if (pose.ok()) found_ = pose.value();
      return pose.status();
    }
    case CommandKind::kRemoveNode:
      return estimator_.remove_node(command.text);
    case CommandKind::kLoadMap:
      return load(estimator_, door_t_, command.text);
    default:
      return Status::kNotFound;
  }
}

// The door's own are fixed once it is open.
Status App::retune(const char* name, float value) {
  AppParams changed = params_;
  switch (set_parameter(changed, name, value).status) {
    case ParamStatus::kOk:
      break;
    case ParamStatus::kNotFound:
    case ParamStatus::kAmbiguous:
      return Status::kNotFound;
    default:
      return Status::kBadData;
  }
  if (std::memcmp(&changed.door, &params_.door, sizeof changed.door) != 0) return Status::kStale;
  const bool exposure =
      std::memcmp(&changed.exposure, &params_.exposure, sizeof changed.exposure) != 0;
  if (exposure) exposure_.retune(changed.exposure);
  params_ = changed;
  fusion_.retune(params_.fusion);
  estimator_.retune(for_lens(params_, calibration_.camera[0]));
  return Status::kOk;
}

Status App::start_recording() {
  PIRVS_TRY(record());
  if (recorder_core_runs_) return Status::kOk;
  const Status status = start_recorder_core();
  if (status == Status::kOk) return status;
  intake_.set_tap({});
  recorder_.finish();
  return status;
}

Status App::stop_recording() {
  if (!recorder_.recording()) return Status::kStale;
  intake_.set_tap({});
  recorder_.stop();
  return Status::kOk;
}

}  // namespace pirvs
