#include "modules/app/app.h"

#include <new>

#include "bsp/api/clock.h"
#include "bsp/api/events.h"
#include "bsp/api/watchdog.h"
#include "core/trace/trace.h"
#include "modules/app/lens_scale.h"

namespace pirvs {
namespace {

static_assert(2 /* door, front-ends */ + Recorder::kFramesHeld <= bsp::kFramesLentMax,
              "the camera has a frame for whoever holds one");

constexpr TimeNs kRecorderRest_ns = 1'000'000;  // in which it writes a file

// For counters(): the scheduler lives from start() to finish() alone.
void copy_counters(const Scheduler& scheduler, TaskCounters* counters) {
  for (size_t i = 0; i < scheduler.size(); ++i) counters[i] = scheduler.counters(i);
}

}  // namespace

void App::configure(const Calibration& calibration, const AppParams& params,
                    const AppSinks& sinks) {
  // Everything anew, whatever an earlier run left behind; in place, since no stack could hold it.
  this->~App();
  new (this) App;
  calibration_ = calibration;
  params_ = params;
  const AppParams scaled = for_lens(params, calibration.camera[0]);
  sinks_ = sinks;
  DoorListener listener;
  listener.context = this;
  listener.fresh = [](void* context, const ImuSample& sample, bool broken) {
    App& app = *static_cast<App*>(context);
    if (broken) app.output_.interrupt();
    app.output_.add_imu(sample);
    if (app.sinks_.imu != nullptr) app.sinks_.imu(app.sinks_.context, sample);
  };
  listener.release = Intake::release;
  door_.configure(calibration, scaled.door, listener);
  const auto next_told = [](void* context, Arrival& out) {
    App& app = *static_cast<App*>(context);
    const ArrivalSource& recorded = app.replayed_;
    if (recorded.next != nullptr && recorded.next(recorded.context, out)) return true;
    return app.inbox_.pop(out);
  };
  intake_.configure(&door_, {}, {this, next_told});
  estimator_.configure(calibration, scaled, sinks);
  output_.configure(pirvs::scaled(calibration.imu, scaled.imu),
                    static_cast<double>(scaled.tracking.tracker.cov_scale),
                    from_seconds(static_cast<double>(scaled.door.bridge_s)));
  fusion_.configure(calibration.gnss, params.fusion);
}

// What was fused before has nothing to say about what comes.
void App::interrupt(TimeNs t, const char* why) {
  estimator_.interrupt(t, why);
  output_.replace(estimator_.fused());
}

void App::take_fix(const GnssFix& fix) {
  bool has_pose = false;
  {
    PIRVS_TRACE("fusion");
    has_pose = fusion_.add_fix(fix);
  }
  if (sinks_.fix != nullptr) sinks_.fix(sinks_.context, fix, fusion_.last_gate());
  if (has_pose) tell_fused();
}

void App::tell_fused() {
  if (sinks_.fused != nullptr) sinks_.fused(sinks_.context, fusion_.pose());
}

// SLAM's pose at a frame. Before a first fix there is nothing to fuse it with.
void App::fuse_pose(const FusedState& fused) {
  if (!fusion_.has_origin()) return;
  Pose pose = pose_of(fused, door_t_, w_B_);
  pose.state.t = door_t_;
  if (!fused.running) pose.health = HealthState::kLost;
  bool has_pose = false;
  {
    PIRVS_TRACE("fusion");
    has_pose = fusion_.add_pose(pose);
  }
  if (has_pose) tell_fused();
}

void App::check_clocks() {
  const int c = (frame_present_ & 1) != 0 ? 0 : 1;
  const ClockCheck::Frame frame = {door_t_, c, &estimator_.tracks(c),
                                   estimator_.tracker().state().b_g};
  const ClockVerdict verdict = door_.judge_clocks(frame);
  if (verdict == ClockVerdict::kRight) return;
  if (verdict == ClockVerdict::kImuSet) fusion_.interrupt();
  interrupt(door_t_, verdict == ClockVerdict::kImuSet ? "the IMU's clock was set"
                                                      : "the cameras' clock was set");
}

// No more is sensed: mapping finishes what it has.
void App::end_when_done() {
  estimator_.map_gate().open();
  if (estimator_.mapping_rests()) scheduler_->stop();
}

// Only live: a recording that is held back must tell the same, however long its steps take.
void App::tell_late(TimeNs now) {
  LateTask late;
  while (late_watch_.next(*scheduler_, now, late)) {
    if (sinks_.late != nullptr) sinks_.late(sinks_.context, door_t_, late);
  }
}

Step App::door_step(TimeNs now) {
  if (live()) {
    intake_.drain_imu();  // each sample is to be told at once, whatever a frame in work takes
    tell_late(now);
  }
  if (!estimator_.idle()) return Step::kIdle;
  if (estimator_.mapping_done()) mapping_done_t_ = door_t_;
  if (command_step()) return Step::kAgain;
  if (ending_) end_when_done();
  const auto held_back = [this] { return held_ = may_go_on_ != nullptr && !may_go_on_(*this); };
  if (ending_ || has_command_ || held_back()) return Step::kIdle;
  DoorItem item;
  Status status = door_.next(item);
  while (status == Status::kEmpty && !held_back() && intake_.poll()) status = door_.next(item);
  if (status == Status::kStale) ending_ = true;
  if (status != Status::kOk) return ending_ ? Step::kAgain : Step::kIdle;
  take(item);
  return Step::kAgain;
}

// Only live: a recording's images are as they are. Failures are the cameras': the frame goes on.
void App::control_exposure() {
  if (!cameras_obey_ || params_.exposure.automatic == 0) return;
  const Result<CameraRange> range = bsp::camera_range();
  Status status = range.status();
  ExposureSetting wanted;
  if (range.ok()) {
    const CameraRange& r = range.value();
    exposure_.set_range({{to_seconds(r.exposure_ns_min), static_cast<double>(r.gain_min)},
                         {to_seconds(r.exposure_ns_max), static_cast<double>(r.gain_max)},
                         {to_seconds(r.exposure_ns_step), static_cast<double>(r.gain_step)}});
    const StereoFrame& images = estimator_.frame().images;
    const ImageInfo& info = images.info[(images.present & 1) != 0 ? 0 : 1];
    ExposureFrame frame;
    frame.t = images.t;
    frame.images = images.image;
    frame.count = kCamerasMax;
    frame.taken = {to_seconds(info.exposure_ns), static_cast<double>(info.gain)};
    if (!exposure_.frame(frame, wanted)) return;
    status =
        bsp::camera_control({from_seconds(wanted.exposure_s), static_cast<float>(wanted.gain)});
  }
  if (status != Status::kNotFound) return;
  cameras_obey_ = false;
  estimator_.tell_health(door_t_, "the cameras take no exposure and gain");
}

Step App::prepare_step() {
  const Step step = estimator_.wait_for_map();
  if (step == Step::kAgain && live()) control_exposure();
  if (step == Step::kAgain && recorder_.recording()) {
    recorder_.decision(door_t_, estimator_.tracker().mapped());
  }
  return step;
}

void App::take(const DoorItem& item) {
  switch (item.kind) {
    case DoorItemKind::kFrame:
      door_t_ = item.frame.t;
      copy_counters(*scheduler_, task_counters_);
      frame_present_ = item.frame.images.present;
      estimator_.begin(item.frame);
      break;
    case DoorItemKind::kImu: {
      const bool in_doubt = door_.in_doubt(item.imu.t);
      if (item.imu.t < door_t_) fusion_.interrupt();
      door_t_ = item.imu.t;
      w_B_ = item.imu.w_B;
      if (item.broken) interrupt(item.imu.t, "input interrupted");
      output_.doubt_stamps(in_doubt);
      exposure_.turn(item.imu.w_B.norm());
      estimator_.imu(item.imu, in_doubt);
      break;
    }
    case DoorItemKind::kCommand:
      executing_ = item.command;
      has_command_ = true;
      break;
    case DoorItemKind::kEvent:
      // While the IMU is silent no pose can be given; faults alone are bridged as any gap is.
      if (item.event == DoorLoss::kImuSilent) {
        interrupt(door_t_, message(item.event));
      } else {
        estimator_.tell_health(door_t_, message(item.event));
      }
      break;
    case DoorItemKind::kGnss:
      take_fix(item.gnss);
      break;
    case DoorItemKind::kWheel:
      estimator_.wheel(item.wheel);
      break;
    case DoorItemKind::kEdge:
      break;  // nobody asks for them yet
  }
}

Step App::tracking_step() {
  if (estimator_.tracking_step() == Step::kIdle) return Step::kIdle;
  const FusedState fused = estimator_.fused();
  output_.fuse(fused);
  fuse_pose(fused);
  check_clocks();
  if (sinks_.tracked != nullptr) {
    const DoorFrame& frame = estimator_.frame();
    sinks_.tracked(sinks_.context, frame.t, frame.images, estimator_.tracker());
  }
  const TimeNs later = estimator_.correct_time();
  door_.watch().correct(later);
  camera_correction_ += later;
  door_.release();
  return Step::kAgain;
}

Status App::start(const CorePlan& plan, Drive drive) {
  PIRVS_ASSERT(drive == Drive::kTimed || plan.cores == 1);
  plan_ = plan;
  drive_ = drive;
  exposure_.configure(params_.exposure, calibration_.camera[0].fx, 1.0 / plan.frames_hz);
  static constexpr Step (*kSteps[kTasks])(void*, TimeNs) = {
      [](void* a, TimeNs now) { return static_cast<App*>(a)->door_step(now); },
      [](void* a, TimeNs) { return static_cast<App*>(a)->prepare_step(); },
      [](void* a, TimeNs) { return static_cast<App*>(a)->estimator_.frontend_step(0); },
      [](void* a, TimeNs) { return static_cast<App*>(a)->estimator_.frontend_step(1); },
      [](void* a, TimeNs) { return static_cast<App*>(a)->tracking_step(); },
      [](void* a, TimeNs) { return static_cast<App*>(a)->estimator_.mapping_step(); },
  };
  const Schedule rows = schedule(plan);
  for (int i = 0; i < kTasks; ++i) {
    tasks_[i] = rows[i];
    tasks_[i].step = kSteps[i];
    tasks_[i].context = this;
  }
  scheduler_.emplace(tasks_, SchedulerHooks{bsp::now, bsp::wait, bsp::wake, bsp::watchdog_kick});
  if (recorder_.started()) PIRVS_TRY(start_recorder_core());
  for (int i = 1; i < plan.cores; ++i) {
    cores_[i] = {&*scheduler_, i};
    const auto entry = [](void* c) {
      const Core& core = *static_cast<Core*>(c);
      core.scheduler->run(core.index);
    };
    if (bsp::start_core(i, entry, &cores_[i]) != Status::kOk) return Status::kBusFault;
  }
  return Status::kOk;
}

Status App::poll() {
  const bool worked =
      drive_ == Drive::kLockstep ? scheduler_->poll_lockstep() : scheduler_->poll(0);
  if (worked) return Status::kOk;
  return scheduler_->stopped() ? Status::kStale : Status::kEmpty;
}

Status App::finish() {
  scheduler_->stop();
  recorder_.end();
  bsp::join_cores();
  copy_counters(*scheduler_, task_counters_);
  scheduler_.reset();
  estimator_.flush_report();
  return estimator_.tracker().running() ? Status::kOk : Status::kBadData;
}

Status App::run(const CorePlan& plan, Drive drive, const AfterStep& after_step) {
  PIRVS_TRY(start(plan, drive));
  for (Status status = Status::kOk; status != Status::kStale;) {
    status = poll();
    if (after_step.call != nullptr) after_step.call(after_step.context);
    if (status != Status::kEmpty) continue;
    if (!held_) break;  // no more will come
    bsp::wait(0, bsp::now() + kRecorderRest_ns);
  }
  return finish();
}

static_assert(sizeof(App) <= kPoolBytesMax, "all static pools of the stack: the board's share");

int App::pools(NamedValue* out, int max) {
  int count = Estimator::pools(out, max);
  const auto add = [&](const char* name, size_t size) {
    if (count < max) out[count++] = {name, size};
  };
  add("recorder", sizeof(recorder_));
  add("output", sizeof(output_));
  add("fusion", sizeof(fusion_));
  size_t named = 0;
  for (int i = 0; i < count; ++i) named += out[i].value;
  add("app", sizeof(App) - named);
  return count;
}

int App::counters(NamedValue* out, int max) const {
  int count = 0;
  const auto add = [&](const char* name, uint64_t value) {
    if (count < max) out[count++] = {name, value};
  };
  for_each_counter(door_.losses(), add);
  if (recorder_.started()) {
    for_each_counter(recorder_.losses(), add);
    add("frames_recorded", recorder_.frames_written());
  }
  add("fused_states_missed", output_.predictor().anchors_missed());
  add("poses_not_finite", output_.predictor().not_finite());
  for_each_counter(fusion_.gates(), add);
  for_each_counter(fusion_.events(), add);
  static constexpr const char* kLate[kTasks][2] = {
      {"overruns_door", "slips_door"},         {"overruns_prepare", "slips_prepare"},
      {"overruns_left", "slips_left"},         {"overruns_right", "slips_right"},
      {"overruns_tracking", "slips_tracking"}, {"overruns_mapping", "slips_mapping"}};
  for (int i = 0; i < kTasks; ++i) {
    add(kLate[i][0], task_counters_[i].overruns);
    add(kLate[i][1], task_counters_[i].slips);
  }
  return count + estimator_.counters(out + count, max - count);
}

}  // namespace pirvs
