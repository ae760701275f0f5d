#include "tools/run/run_log.h"

#include <algorithm>

namespace pirvs::tools {
namespace {

constexpr size_t kKeyframesExpected = 8192;
constexpr int kNamedMax = 512;

void on_frame(void* context, const FrameReport& report) {
  auto& log = *static_cast<RunLog*>(context);
  for (RunListener* listener : log.listeners) listener->frame(report);
  log.frames.push_back(report);
}

void on_health(void* context, TimeNs t, HealthState state, const char* what) {
  auto& log = *static_cast<RunLog*>(context);
  for (RunListener* listener : log.listeners) listener->health(t, state, what);
  log.health.push_back({t, state, what});
}

void on_answer(void* context, const Answer& answer) {
  for (RunListener* listener : static_cast<RunLog*>(context)->listeners) listener->answer(answer);
}

void on_tracked(void* context, TimeNs t, const StereoFrame& images, const Tracker& tracker) {
  for (RunListener* listener : static_cast<RunLog*>(context)->listeners) {
    listener->tracked(t, images, tracker);
  }
}

void on_late(void* context, TimeNs t, const LateTask& task) {
  static_cast<RunLog*>(context)->late.push_back({t, task});
}

void on_fused(void* context, const FusedPose& pose) {
  auto& log = *static_cast<RunLog*>(context);
  for (RunListener* listener : log.listeners) listener->fused(pose);
  log.fused.push_back(pose);
}

void on_fix(void* context, const GnssFix& fix, FixGate gate) {
  auto& log = *static_cast<RunLog*>(context);
  for (RunListener* listener : log.listeners) listener->fix(fix, gate);
  log.fixes.push_back({fix, gate});
}

void on_keyframe(void* context, const BodyState& state) {
  static_cast<RunLog*>(context)->keyframes.push_back(state);
}

std::vector<Count> named(const NamedValue* values, int count) {
  std::vector<Count> out;
  for (int i = 0; i < count; ++i) out.push_back({values[i].name, size_t(values[i].value)});
  return out;
}

}  // namespace

RunLog::RunLog(size_t frames_expected) {
  frames.reserve(frames_expected + 1);
  health.reserve(1024);
  late.reserve(1024);
  keyframes.reserve(kKeyframesExpected);
}

AppSinks RunLog::sinks() {
  AppSinks sinks;
  sinks.context = this;
  sinks.frame = on_frame;
  sinks.health = on_health;
  if (!listeners.empty()) {
    sinks.answer = on_answer;
    sinks.tracked = on_tracked;
  }
  sinks.late = on_late;
  sinks.fused = on_fused;
  sinks.fix = on_fix;
  sinks.keyframe = on_keyframe;
  return sinks;
}

void RunLog::attach(App& app, size_t poses_expected) {
  poses.reserve(poses_expected);
  const Result<int> consumer = app.poses().attach();
  if (consumer.ok()) consumer_ = consumer.value();
}

void RunLog::take_poses(App& app) {
  if (consumer_ < 0) return;
  while (const Pose* const pose = app.poses().next(consumer_)) {
    for (RunListener* listener : listeners) listener->pose(*pose);
    poses.push_back({pose->state.t, pose->t_published});
  }
}

void RunLog::finish(App& app) {
  if (consumer_ >= 0) app.poses().detach(consumer_);
  consumer_ = -1;
  const Map& map = app.map();
  for (size_t slot = 0; slot < map.keyframes.capacity(); ++slot) {
    if (const Keyframe* keyframe = map.keyframes.at(slot)) keyframes.push_back(keyframe->state);
  }
  std::sort(keyframes.begin(), keyframes.end(),
            [](const BodyState& a, const BodyState& b) { return a.t < b.t; });
  for (size_t slot = 0; slot < map.landmarks.capacity(); ++slot) {
    if (const Landmark* landmark = map.landmarks.at(slot)) points.push_back(*landmark);
  }
  local_frame = app.local_frame();
  NamedValue values[kNamedMax];
  counters = named(values, app.counters(values, kNamedMax));
  pools = named(values, App::pools(values, kNamedMax));
  imu_to_pose = app.latency().imu_to_pose.summary();
  calibration = app.self_calibration();
  wheel_scale = app.wheel_scale();
  for (int i = 0; i < 4; ++i) calibration_news[i] = app.calibration_news(i);
  camera_correction = app.camera_correction();
  exposure_to_fused = app.latency().exposure_to_fused.summary();
}

}  // namespace pirvs::tools
