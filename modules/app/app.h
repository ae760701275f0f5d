// The whole stack as one static object: sensors in by the bsp's contracts, commands by the door,
// poses out by sinks. Wires door, estimator and recorder, and does nothing else.
// In      bsp::camera_poll, imu_poll, tick_poll; a Calibration; parameters; command(), deliver().
// Out     poses(): one at every IMU sample, for each consumer. AppSinks: a report per frame, health
//         changes, answers. The map at the end.
// Frames  W: world, z up, origin at the first keyframe. B: IMU. Time: the IMU's clock, ns.
// Errors  kBadData: the sensors ended before a start. Rejected samples are counted.
// Cost    memory: see pools(); time: see FrameReport.
// Source  docs/architecture.md.
#pragma once

#include <optional>

#include "bsp/api/cores.h"
#include "core/base/status.h"
#include "core/sched/late_watch.h"
#include "modules/app/app_params.h"
#include "modules/app/app_sinks.h"
#include "modules/app/estimator.h"
#include "modules/app/intake.h"
#include "modules/app/schedule.h"
#include "modules/calibration/calibration.h"
#include "modules/door/door.h"
#include "modules/door/inbox.h"
#include "modules/exposure/auto_exposure.h"
#include "modules/fusion/fusion.h"
#include "modules/map/map_file.h"
#include "modules/output/output.h"
#include "modules/recorder/recorder.h"

namespace pirvs {

// kTimed: every core runs its rows by the clock, as live sensors need it. kLockstep: one core runs
// all rows in an order that depends on the input alone: the same input, the same bytes.
enum class Drive : uint8_t { kTimed, kLockstep };

struct AfterStep {
  void* context = nullptr;
  void (*call)(void*) = nullptr;
};

// Life: configure, perhaps record(), pace(), delay_mapping(), then run(), or start, poll until
// kStale, finish. All of that on one core, which becomes core 0 of the plan.
// Many methods: life, commands and wiring of the whole device, a line or a few each.
class App {
 public:
  // Forgets everything from an earlier run.
  void configure(const Calibration& calibration, const AppParams& params, const AppSinks& sinks);
  // Whatever comes to the door is also written by bsp/api/storage.h as an ASL folder, from a core
  // of its own, the first that the plan leaves free. kBusFault, kFull, kNotFound: the storage
  // refuses, or AppSinks::new_recording does. kStale: one is being written.
  Status record();
  // A recording that is there all at once is held back while this says false (replay_pace.h). Asked
  // on the door's core. Live sensors are never held back.
  void pace(bool (*may_go_on)(const App&)) { may_go_on_ = may_go_on; }
  // Before start(): the map of an earlier run, where a start looks for its place. Errors as
  // modules/map/map_file.h; the map is empty then.
  Status load_map(const MapSource& source) { return estimator_.load_map(0, source); }
  // For tests: each of mapping's results reaches tracking exactly so many frames after the frame
  // that could have it first, however fast mapping is. 0 to MapGate::kLagMax.
  void delay_mapping(int frames) { estimator_.map_gate().configure(frames); }

  // Starts the other cores. kBusFault: a core refuses. kLockstep wants a plan of one core.
  Status start(const CorePlan& plan, Drive drive);
  // Core 0's next step. kOk: something was done, or core 0 has rested a while. kEmpty (kLockstep):
  // there is nothing to do until more is sensed. kStale: all is done, by the sensors' end or by a
  // command; finish().
  Status poll();
  // Waits for the other cores. kBadData: the run ended before a start.
  Status finish();
  // The three in one, and after each step what else core 0 is there for. In lockstep the first
  // kEmpty ends it, too.
  Status run(const CorePlan& plan, Drive drive, const AfterStep& after_step = {});

  // Any core. Taken in order with what is sensed, answered by AppSinks::answer. kFull: too many
  // wait.
  Result<uint32_t> command(const Command& command);

  // Any core: a GNSS fix, wheel sample or edge, or that a driver has lost its sensor or has it
  // back. kFull: too many wait.
  Status deliver(const Arrival& arrival);

  // What a recording holds of both, each at its turn; between configure() and start().
  void replay_inbox(const ArrivalSource& source) { replayed_ = source; }
  // Likewise how far mapping had come at each frame; instead of delay_mapping().
  void replay_maps(const MapDecisions& maps) { estimator_.map_gate().follow(maps); }

  // How long, in sensor time, mapping has had work left; 0: it has none. The door's core.
  TimeNs mapping_backlog() const {
    return estimator_.mapping_done() ? 0 : door_t_ - mapping_done_t_;
  }
  bool recorder_has_room() const { return !recorder_.recording() || recorder_.has_room(); }

  // Before start(): the clock of the sensors' stamps, or latency() stays empty (output.h).
  void set_clock(TimeNs (*now)()) { output_.set_clock(now); }
  PoseFeed& poses() { return output_.feed(); }
  const Latency& latency() const { return output_.latency(); }  // from any core
  // At rest: how far the calibration is off, as it was told, of time, turn and wheels ("": it is
  // not); in numbers; by how much the cameras' offset was corrected.
  const char* calibration_news(int i) const { return estimator_.calibration_news(i); }
  SelfCalibration::Estimate self_calibration() const {
    return estimator_.tracker().self_calibration();
  }
  TimeNs camera_correction() const { return camera_correction_; }
  double wheel_scale() const { return estimator_.tracker().wheel_scale(); }  // 1: as calibrated
  // East, north, up about the first good fix: where AppSinks::fused stands. The door's core.
  const LocalFrame& local_frame() const { return fusion_.frame(); }

  const Map& map() const { return estimator_.map(); }  // once finished
  // The landmarks that tracking sees now, each once; the door's core. Returns the count.
  int seen_points(SeenPoint* out, int max) const {
    return estimator_.tracker().seen_points(out, max);
  }
  // Every counter of rejections and faults, from any core, also while it runs; sizes of the static
  // pools in bytes. Return the count.
  int counters(NamedValue* out, int max) const;
  static int pools(NamedValue* out, int max);

 private:
  struct Core {
    Scheduler* scheduler;
    int index;
  };

  // Sensors, and not a recording that is held back: what the clock says means something.
  bool live() const { return drive_ == Drive::kTimed && may_go_on_ == nullptr; }
  Step door_step(TimeNs now);
  Step prepare_step();
  Step tracking_step();
  void take(const DoorItem& item);
  void interrupt(TimeNs t, const char* why);
  void fuse_pose(const FusedState& fused);
  void take_fix(const GnssFix& fix);
  void tell_fused();
  void end_when_done();
  void tell_late(TimeNs now);
  void control_exposure();
  void check_clocks();
  bool command_step();
  Status execute(const Command& command);
  Status execute_at_rest(const Command& command);
  Status retune(const char* name, float value);
  Status start_recording();
  Status stop_recording();
  Status start_recorder_core();

  Calibration calibration_;
  AppParams params_;  // as set, for any lens
  AppSinks sinks_;
  Door door_;
  Intake intake_;
  Estimator estimator_;
  Output output_;
  Fusion fusion_;
  Vec3 w_B_ = Vec3::Zero();  // as the gyro last measured it
  Recorder recorder_;
  bool recorder_core_runs_ = false;
  MapIndex map_index_;
  AutoExposure exposure_;
  bool cameras_obey_ = true;  // until they say that they cannot be told

  Inbox inbox_;
  ArrivalSource replayed_;
  Command executing_;
  SE3 found_;  // by kGetNode
  bool has_command_ = false;
  bool ending_ = false;  // no more is taken from the sensors
  bool held_ = false;    // may_go_on_ said no when it was last asked
  bool (*may_go_on_)(const App&) = nullptr;
  uint8_t frame_present_ = 0;
  TimeNs door_t_ = 0;  // of the last item handed out
  TimeNs camera_correction_ = 0;
  TimeNs mapping_done_t_ = 0;  // when mapping last had nothing to do, sensor time

  CorePlan plan_;
  Drive drive_ = Drive::kTimed;
  Task tasks_[kTasks];
  std::optional<Scheduler> scheduler_;  // while running
  Core cores_[bsp::kCoresMax];
  TaskCounters task_counters_[kTasks];
  LateWatch late_watch_;
};

}  // namespace pirvs
