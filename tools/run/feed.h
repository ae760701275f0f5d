// What    A recording as bsp/replay wants it: decoded, through the faults asked for.
// In      An open Recording, which must outlive the feed; faults, perhaps none.
// Out     source() for bsp::replay_start; frames_played() for a progress bar.
// Frames  as recorded.
// Errors  InputError on construction: no image can be read; a fault that cannot happen.
// Cost    that of the player.
// Source  DESIGN.md, "Folders": board/host runs on recorded sensors.
#pragma once

#include <functional>

#include "bsp/replay/replay.h"
#include "tools/dataset/player.h"
#include "tools/run/fault.h"

namespace pirvs::tools {

class Feed {
 public:
  explicit Feed(const Recording& recording, const std::vector<Fault>& faults = {},
                std::function<void(size_t played)> on_frame = {});
  bsp::RecordingSource source();

  std::vector<Count> rejected() const { return player_.rejected(); }
  std::vector<Count> faults_applied() const { return faults_.applied(); }

 private:
  static bool next_imu(void* context, ImuSample& out);
  static bool next_frame(void* context, StereoFrame& out);
  static void release_frame(void* context);

  const Recording& recording_;
  FaultLine faults_;
  Player player_;
  std::function<void(size_t)> on_frame_;
  size_t imu_at_ = 0;
};

}  // namespace pirvs::tools
