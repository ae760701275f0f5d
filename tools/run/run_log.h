// What    Everything a run has to tell, as it came out of the App: what the files and the report
//         are made of.
// In      App's sinks while it runs; the App itself at the end.
// Out     Frames, health events, late tasks, keyframes, map points, counters, pools; when each pose
//         at IMU rate was published.
// Frames  W: the estimator's world. B: IMU.
// Units   as in modules/app/app.h.
// Errors  none.
// Cost    ~1 kB a frame, allocated ahead so that the sinks do not disturb the timing.
#pragma once

#include <string>
#include <vector>

#include "modules/app/app.h"
#include "tools/dataset/recording.h"

namespace pirvs::tools {

struct HealthEvent {
  TimeNs t = 0;
  HealthState state = HealthState::kInitializing;
  std::string what;
};

struct LateEvent {
  TimeNs t = 0;  // of the newest item that the door has handed out
  LateTask task;
};

struct PublishedPose {
  TimeNs t = 0;            // of its IMU sample
  TimeNs t_published = 0;  // on the same clock
};

struct FixEvent {
  GnssFix fix;
  FixGate gate = FixGate::kAccepted;
};

// Whoever wants some of it while the run goes on. All on core 0.
class RunListener {
 public:
  virtual ~RunListener() = default;
  virtual void frame(const FrameReport&) {}
  virtual void tracked(TimeNs, const StereoFrame&, const Tracker&) {}  // lent until it returns
  virtual void pose(const Pose&) {}                                    // in real time alone
  virtual void health(TimeNs, HealthState, const char* what) = 0;
  virtual void fused(const FusedPose&) {}
  virtual void fix(const GnssFix&, FixGate) {}
  virtual void answer(const Answer& answer) = 0;
};

struct RunLog {
  std::vector<FrameReport> frames;  // in order of time, one per frame that went through
  std::vector<HealthEvent> health;
  std::vector<FusedPose> fused;      // with GNSS alone, as they came
  LocalFrame local_frame;            // where they stand
  std::vector<FixEvent> fixes;       // as they came
  std::vector<LateEvent> late;       // live alone
  std::vector<PublishedPose> poses;  // in real time alone
  std::vector<BodyState> keyframes;  // sorted by time after finish()
  std::vector<Landmark> points;
  std::vector<Count> counters;
  std::vector<Count> pools;  // bytes
  LatencySummary imu_to_pose, exposure_to_fused;
  SelfCalibration::Estimate calibration;  // what the calibration's values have left over
  std::string calibration_news[4];        // time, turn, wheels and pair, or empty
  double wheel_scale = 1;                 // wheels.estimate_scale: what they were multiplied by
  TimeNs camera_correction = 0;           // --estimate time: on top of the calibration's offset

  std::vector<RunListener*> listeners;  // before sinks()

  explicit RunLog(size_t frames_expected);
  AppSinks sinks();
  // In real time: once App is configured, and then again and again while it runs, from core 0.
  void attach(App& app, size_t poses_expected);
  void take_poses(App& app);
  void finish(App& app);

 private:
  int consumer_ = -1;  // of App's poses
};

}  // namespace pirvs::tools
