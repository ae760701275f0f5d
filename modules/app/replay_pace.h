// How fast a recording that is there all at once may come to an App: for App::pace().
// In      the App, on the door's core.
// Errors  none. Cost: a few loads.
// Source  docs/adr/0003-lockstep-determinism.md.
#pragma once

#include "modules/app/app.h"

namespace pirvs {

// The next item comes when mapping has nothing left to do: any plan gives the bytes of one core.
inline bool lockstep_may_go_on(const App& app) {
  return app.mapping_backlog() == 0 && app.recorder_has_room();
}

// Mapping may lag as on a device that needs two frames for a keyframe.
inline bool fast_may_go_on(const App& app) {
  constexpr TimeNs kLag_ns = 100'000'000;
  return app.mapping_backlog() <= kLag_ns && app.recorder_has_room();
}

}  // namespace pirvs
