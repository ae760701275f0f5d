// What    Runs an App on a recording, at the pace asked for.
// In      A configured App, what plays the recording, the plan of cores; what else to do after each
//         step of core 0.
// Errors  as App::run.
// Source  docs/adr/0003-lockstep-determinism.md.
#pragma once

#include <functional>

#include "bsp/replay/sensors.h"
#include "modules/app/replay_pace.h"

namespace pirvs::tools {

enum class Playback : uint8_t {
  kFast,      // as fast as possible; on one core the same input gives the same bytes
  kLockstep,  // the bytes of one core on any number of them
  kRealTime,  // as live sensors would
};

inline Status play(App& app, const bsp::RecordingSource& source, const CorePlan& plan,
                   Playback playback, const std::function<void()>& after_step = {}) {
  const bool real_time = playback == Playback::kRealTime;
  const bool lockstep = playback == Playback::kLockstep || plan.cores == 1;
  bsp::play(source, real_time ? bsp::ReplayPace::kRealTime : bsp::ReplayPace::kFast);
  if (real_time) app.set_clock(bsp::replay_now);
  if (!real_time) app.pace(lockstep ? lockstep_may_go_on : fast_may_go_on);
  const auto call = [](void* to) { (*static_cast<const std::function<void()>*>(to))(); };
  AfterStep after;
  if (after_step) after = {const_cast<std::function<void()>*>(&after_step), call};
  return app.run(plan, !real_time && plan.cores == 1 ? Drive::kLockstep : Drive::kTimed, after);
}

}  // namespace pirvs::tools
