#include "modules/app/app.h"

#include <cmath>
#include <cstring>
#include <new>

#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/watchdog.h"
#include "core/trace/trace.h"
#include "modules/app/lens_scale.h"

namespace pirvs {
namespace {

// What the health log says of a frame; nullptr: nothing.
const char* event_of(const FrameResult& result) {
  if (result.started) return result.started_at_rest ? "started at rest" : "started in motion";
  if (result.joined) return "recognised the old map";
  if (result.closed) return "closed a loop";
  if (result.recognised) return "recognised the place";
  return result.health_changed ? "health changed" : nullptr;
}

constexpr TimeNs kDoubtMax_ns = 2'000'000'000;  // undecided for longer: a body that hardly turns

float to_ms(int64_t ns) { return static_cast<float>(ns) * 1e-6f; }

}  // namespace

void App::configure(const Calibration& calibration, const AppParams& params,
                    const AppSinks& sinks) {
  // Everything anew, whatever an earlier run left behind; in place, since no stack could hold it.
  this->~App();
  new (this) App;
  calibration_ = calibration;
  params_ = for_lens(params, calibration.camera[0]);
  sinks_ = sinks;
  door_.configure(calibration, params_.door);
  clock_check_.configure(calibration.camera);
  for (int c = 0; c < kCamerasMax; ++c) {
    frontend_[c].configure(calibration.camera[c], params_.frontend);
  }
  const ImuNoise noise = scaled(calibration.imu, params_.imu);
  tracker_.configure(calibration.camera, calibration.cameras, noise, params_.tracking,
                     &keyframe_ring_, &map_mailbox_);
  mapper_.configure(calibration.camera, noise, params_.mapping, &keyframe_ring_, &map_mailbox_);
  mapper_.on_keyframe_removed(sinks.keyframe, sinks.context);
}

Status App::record() {
  const Status status = recorder_.start(calibration_.camera, calibration_.cameras, calibration_.imu,
                                        calibration_.camera_time_offset);
  if (status != Status::kOk) {
    recorder_.finish();
    return status;
  }
  const auto imu = [](void* r, const ImuSample& sample) { static_cast<Recorder*>(r)->imu(sample); };
  const auto frame = [](void* r, const StereoFrame& f) { static_cast<Recorder*>(r)->frame(f); };
  door_.configure(calibration_, params_.door, {&recorder_, imu, frame});
  return Status::kOk;
}

Status App::start_recorder() {
  if (!recorder_.started()) return Status::kOk;
  const auto entry = [](void* r) { static_cast<Recorder*>(r)->run(bsp::relax); };
  return bsp::start_core(plan_.cores, entry, &recorder_);
}

// Time does not go on from the item before: nothing can be carried over but the map's frame.
void App::interrupt(TimeNs t, const char* why) {
  tracker_.interrupt();
  for (Frontend& frontend : frontend_) frontend.reset();
  if (sinks_.health != nullptr) {
    sinks_.health(sinks_.context, t, tracker_.health(), why);
  }
}

// Until it is known whether a clock was set, nothing of it may get into the map.
bool App::stamps_in_doubt(TimeNs t) const {
  const ClockDoubt& doubt = door_.doubt();
  if (doubt.shift == 0) return false;
  const TimeNs delay = doubt.shift > 0 ? doubt.shift : 0;  // of the samples that decide
  return doubt.since == 0 || t - doubt.since <= kDoubtMax_ns + delay;
}

void App::check_clocks() {
  const ClockDoubt doubt = door_.doubt();
  const int c = (frame_.images.present & 1) != 0 ? 0 : 1;
  const ClockCheck::Frame frame = {frame_.t, c, &frontend_[c].tracks(), tracker_.state().b_g};
  switch (clock_check_.frame(frame, doubt.shift)) {
    case ClockCheck::Verdict::kOpen:
      break;
    case ClockCheck::Verdict::kHold:
      door_.clocks_are_right();
      break;
    case ClockCheck::Verdict::kSet:
      door_.clock_was_set();
      interrupt(frame_.t, doubt.is_imus ? "the IMU's clock was set" : "the cameras' clock was set");
      break;
  }
}

void App::deliver(const ImuSample& sample) {
  const TimeNs begin = bsp::cpu_time();
  {
    PIRVS_TRACE("imu");
    tracker_.doubt_stamps(stamps_in_doubt(sample.t));
    tracker_.add_imu(sample);
    clock_check_.add_imu(sample);
  }
  tracking_ns_ += bsp::cpu_time() - begin;
  if (tracker_.running() && sinks_.pose != nullptr) {
    sinks_.pose(sinks_.context,
                {tracker_.state(), tracker_.cov(), tracker_.health(), tracker_.trust()});
  }
}

void App::begin_frame(const DoorFrame& frame) {
  flush_report();
  const TimeNs begin = bsp::cpu_time();
  frame_ = frame;
  for (int c = 0; c < kCamerasMax; ++c) {
    if ((frame.images.present >> c & 1) == 0) frontend_[c].reset();
  }
  gravity_B_ = tracker_.prepare(frontend_);
  tracking_ns_ += bsp::cpu_time() - begin;
  frontends_left_.store(kCamerasMax);
  stage_.store(Stage::kFrontend, std::memory_order_release);
  for (auto& todo : frontend_todo_) todo.store(true, std::memory_order_release);
}

bool App::world_waits(TimeNs t) const {
  if (pace_ == Pace::kSensors) return false;
  if (mapper_.finished() == tracker_.sent()) return false;
  const bool lockstep = plan_.cores == 1 || pace_ == Pace::kLockstep;
  return lockstep || t - mapping_pending_t_ > kMappingLag_ns;
}

Step App::door_step() {
  if (stage_.load(std::memory_order_acquire) != Stage::kFree) return Step::kIdle;
  if (mapper_.finished() == tracker_.sent()) mapping_pending_t_ = door_t_;
  if (world_waits(door_t_)) return Step::kIdle;
  DoorItem item;
  if (recorder_.started() && pace_ == Pace::kAsWeGo && !recorder_.has_room()) {
    bsp::relax();
    return Step::kAgain;
  }
  const Status status = door_.next(item);
  if (status == Status::kStale && mapper_.finished() == tracker_.sent()) scheduler_->stop();
  if (status == Status::kTimeout) interrupt(door_t_, "the IMU is silent");
  if (status != Status::kOk) return Step::kIdle;
  door_t_ = item.is_frame ? item.frame.t : item.imu.t;
  if (item.is_frame) {
    PIRVS_TRACE("door.frame");
    begin_frame(item.frame);
  } else {
    if (item.broken) {
      interrupt(item.imu.t, "input interrupted");
      clock_check_.reset();
    }
    deliver(item.imu);
  }
  return Step::kAgain;
}

Step App::frontend_step(int c) {
  if (!frontend_todo_[c].load(std::memory_order_acquire)) return Step::kIdle;
  PIRVS_TRACE("frontend");
  const TimeNs begin = bsp::cpu_time();
  if ((frame_.images.present >> c & 1) != 0) {
    const Vec3 gravity_C = calibration_.camera[c].T_BC.R.transpose() * gravity_B_;
    (void)frontend_[c].process(frame_.images.image[c], frame_.t, gravity_C);
  }
  frontend_ns_[c].store(bsp::cpu_time() - begin);
  frontend_todo_[c].store(false, std::memory_order_relaxed);
  if (frontends_left_.fetch_sub(1) == 1) stage_.store(Stage::kTracking, std::memory_order_release);
  return Step::kAgain;
}

Step App::tracking_step() {
  if (stage_.load(std::memory_order_acquire) != Stage::kTracking) return Step::kIdle;
  PIRVS_TRACE("tracking");
  const TimeNs begin = bsp::cpu_time();
  {
    PIRVS_TRACE("matching");
    tracker_.match(frontend_);
  }
  const TimeNs matched = bsp::cpu_time();
  const FrameResult result = tracker_.frame(frame_.t, frame_.images.present, frontend_);
  tracking_ns_ += bsp::cpu_time() - matched;

  report_ = FrameReport{};
  report_.t = frame_.t;
  report_.has_pose = result.has_pose;
  report_.pose = {tracker_.state(), tracker_.cov(), tracker_.health(), tracker_.trust()};
  report_.image_ms = to_ms(frontend_ns_[0] + frontend_ns_[1]);
  report_.matching_ms = to_ms(matched - begin);
  report_.tracking_ms = to_ms(tracking_ns_);
  for (int c = 0; c < kCamerasMax; ++c) {
    report_.tracks[c] = static_cast<int>(frontend_[c].tracks().size());
  }
  report_.correspondences = result.correspondences;
  report_.accepted = result.accepted;
  report_.keyframe = result.keyframe;
  report_.at_rest = result.at_rest;
  report_pending_ = true;
  tracking_ns_ = 0;
  const char* what = event_of(result);
  if (what != nullptr && sinks_.health != nullptr) {
    sinks_.health(sinks_.context, frame_.t, tracker_.health(), what);
  }
  check_clocks();
  door_.release();
  stage_.store(Stage::kFree, std::memory_order_release);
  return Step::kAgain;
}

Step App::mapping_step() {
  if (!mapper_.busy()) return Step::kIdle;
  PIRVS_TRACE("mapping");
  const TimeNs begin = bsp::cpu_time();
  mapper_.step();
  mapping_ns_ += bsp::cpu_time() - begin;
  return Step::kAgain;
}

// A frame is reported when the next one begins, so that mapping's share of the time is known.
void App::flush_report() {
  if (!report_pending_) return;
  report_pending_ = false;
  report_.mapping_ms = to_ms(mapping_ns_.exchange(0));
  report_.end_to_end_ms =
      report_.image_ms + report_.matching_ms + report_.tracking_ms + report_.mapping_ms;
  if (sinks_.frame != nullptr) sinks_.frame(sinks_.context, report_);
}

Status App::run(const CorePlan& plan, Pace pace) {
  plan_ = plan;
  pace_ = pace;
  // Budgets are those of an RK3399's A72 at 60 frames a second; periods 0 wait for what is above.
  const Task tasks[kTasks] = {
      // name         step                                              context  period  budget core
      {"door", [](void* a, TimeNs) { return static_cast<App*>(a)->door_step(); }, this, 0, 200,
       plan.door},
      {"left", [](void* a, TimeNs) { return static_cast<App*>(a)->frontend_step(0); }, this, 0,
       6'000, plan.left},
      {"right", [](void* a, TimeNs) { return static_cast<App*>(a)->frontend_step(1); }, this, 0,
       6'000, plan.right},
      {"tracking", [](void* a, TimeNs) { return static_cast<App*>(a)->tracking_step(); }, this, 0,
       4'000, plan.tracking},
      {"mapping", [](void* a, TimeNs) { return static_cast<App*>(a)->mapping_step(); }, this, 0,
       2'000, plan.mapping},
  };
  Scheduler scheduler(tasks, {bsp::now, bsp::relax, bsp::watchdog_kick});
  scheduler_ = &scheduler;
  PIRVS_TRY(start_recorder());
  if (plan.cores == 1 && pace != Pace::kSensors) {
    scheduler.run_until_idle();
  } else {
    struct Core {
      Scheduler* scheduler;
      int index;
    } cores[bsp::kCoresMax];
    for (int i = 1; i < plan.cores; ++i) {
      cores[i] = {&scheduler, i};
      const auto entry = [](void* c) {
        const Core& core = *static_cast<Core*>(c);
        core.scheduler->run(core.index);
      };
      if (bsp::start_core(i, entry, &cores[i]) != Status::kOk) return Status::kBusFault;
    }
    scheduler.run(0);
  }
  recorder_.stop();
  bsp::join_cores();
  scheduler_ = nullptr;
  for (int i = 0; i < kTasks; ++i) task_counters_[i] = scheduler.counters(static_cast<size_t>(i));
  flush_report();
  return tracker_.running() ? Status::kOk : Status::kBadData;
}

static_assert(sizeof(App) <= kPoolBytesMax, "all static pools of the stack: the board's share");

int App::pools(NamedValue* out, int max) {
  const NamedValue table[] = {
      {"frontend", sizeof(frontend_)},
      {"tracker", sizeof(tracker_)},
      {"mapper", sizeof(mapper_)},
      {"recorder", sizeof(recorder_)},
      {"keyframe_ring", sizeof(keyframe_ring_)},
      {"map_mailbox", sizeof(map_mailbox_)},
      {"app", sizeof(App) - sizeof(frontend_) - sizeof(tracker_) - sizeof(mapper_) -
                  sizeof(recorder_) - sizeof(keyframe_ring_) - sizeof(map_mailbox_)},
  };
  int count = 0;
  for (const NamedValue& row : table) {
    if (count < max) out[count++] = row;
  }
  return count;
}

int App::counters(NamedValue* out, int max) const {
  int count = 0;
  const auto add = [&](const char* name, uint64_t value) {
    if (count < max) out[count++] = {name, value};
  };
  for (int i = 0; i < static_cast<int>(DoorLoss::kCount); ++i) {
    add(name(static_cast<DoorLoss>(i)), door_.losses().count[i]);
  }
  for (int i = 0; recorder_.started() && i < static_cast<int>(RecordLoss::kCount); ++i) {
    add(name(static_cast<RecordLoss>(i)), recorder_.losses(static_cast<RecordLoss>(i)));
  }
  if (recorder_.started()) add("frames_recorded", recorder_.frames_written());
  for (int i = 0; i < static_cast<int>(TrackLoss::kCount); ++i) {
    add(name(static_cast<TrackLoss>(i)), frontend_[0].losses()[i] + frontend_[1].losses()[i]);
  }
  for (int i = 0; i < static_cast<int>(StereoLoss::kCount); ++i) {
    add(name(static_cast<StereoLoss>(i)), tracker_.stereo().losses()[i]);
  }
  const TrackingCounters& t = tracker_.counters();
  for (int i = 0; i < static_cast<int>(Gate::kCount); ++i) {
    add(name(static_cast<Gate>(i)), t.gates[i]);
  }
  static constexpr const char* kOverruns[kTasks] = {
      "overruns_door", "overruns_left", "overruns_right", "overruns_tracking", "overruns_mapping"};
  for (int i = 0; i < kTasks; ++i) add(kOverruns[i], task_counters_[i].overruns);
  add("frames", t.frames);
  add("frames_with_pose", t.frames_with_pose);
  add("starts", t.starts);
  add("start_failures", t.start_failures);
  add("losses", t.losses);
  add("keyframes", t.keyframes);
  add("keyframes_dropped", t.keyframes_dropped);
  add("snapshots_late", t.snapshots_late);
  add("matched_by_projection", t.matched_by_projection);
  add("standstill_frames", t.standstill_frames);
  add("tracks_dropped", t.tracks_dropped);
  add("recognitions", t.recognitions);
  add("recognitions_failed", t.recognitions_failed);
  add("joins", t.joins);
  add("loops", t.loops);
  add("loops_implausible", t.loops_implausible);
  add("loops_held", t.loops_held);
  add("jumps", t.jumps);
  const MappingCounters& m = mapper_.counters();
  add("keyframes_removed", m.keyframes_removed);
  add("adjustments", m.adjustments);
  add("adjustments_failed", m.adjustments_failed);
  add("points_stereo", m.points_stereo);
  add("points_temporal", m.points_temporal);
  add("points_removed", m.points_removed);
  add("points_full", m.points_full);
  add("points_forgotten", m.points_forgotten);
  add("points_rejected", m.points_rejected);
  add("observations_removed", m.observations_removed);
  add("bundle_full", m.bundle_full);
  add("restarts", m.restarts);
  return count;
}

}  // namespace pirvs
