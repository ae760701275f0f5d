// What    A recording as bsp/replay wants it: decoded, through the faults asked for.
// In      An open Recording, which must outlive the feed; faults, perhaps none; how much later than
//         its own time a frame comes.
// Out     source() for bsp::play: items come in the order of recorded time, whatever a fault
//         does to their stamps; or, as fast as possible, in the recorded order if there is one.
// Frames  as recorded.
// Errors  InputError on construction: no image can be read; a fault that cannot happen.
// Cost    that of the player.
// Source  DESIGN.md, "Folders": board/host runs on recorded sensors.
#pragma once

#include <csignal>
#include <functional>

#include "bsp/replay/replay.h"
#include "modules/app/intake.h"
#include "modules/app/map_gate.h"
#include "tools/dataset/player.h"
#include "tools/run/fault.h"

namespace pirvs::tools {

class Feed {
 public:
  explicit Feed(const Recording& recording, const std::vector<Fault>& faults = {},
                std::function<void(size_t played)> on_frame = {}, TimeNs camera_latency = 0);
  bsp::RecordingSource source();

  // What was told in the recorded run, each at its turn, or the recording's fixes as they would
  // have come: for App::replay_inbox().
  ArrivalSource inbox() { return {this, next_told}; }
  // Fixes and wheels alone, in real time.
  ArrivalSource others() { return {this, next_other_told}; }
  // Ends as the recording would once `flag` is not 0: a signal may set it.
  void end_when(const volatile std::sig_atomic_t* flag) { ended_ = flag; }
  // Up to which keyframe mapping had come when each recorded frame began.
  MapDecisions maps() { return {this, next_map}; }

  std::vector<Count> rejected() const { return player_.rejected(); }
  std::vector<Count> faults_applied() const { return faults_.applied(); }

 private:
  static bool next_imu(void* context, ImuSample& out);
  static bool next_frame(void* context, StereoFrame& out);
  static void release_frame(void* context, FrameId id);
  static TimeNs arrival(void* context, bool frame);
  static bool order(void* context, bsp::RecordedArrival& out);
  static void go_on(void* context) { ++static_cast<Feed*>(context)->order_at_; }
  static bool next_told(void* context, Arrival& out);
  static bool next_other_told(void* context, Arrival& out);
  bool next_fix_told(Arrival& out);
  bool next_wheel_told(Arrival& out);
  static bool next_map(void* context, uint32_t& keyframe);
  bool ended() const { return ended_ != nullptr && *ended_ != 0; }

  const Recording& recording_;
  FaultLine faults_;
  Player player_;
  std::function<void(size_t)> on_frame_;
  const StereoFrame* lent_[bsp::kReplayFrames] = {};  // by the slot of its id
  const volatile std::sig_atomic_t* ended_ = nullptr;
  TimeNs camera_delay_;              // from a frame's stamp to its arrival, on the IMU's clock
  bool follows_order_;               // faults and a latency would change it
  bool tells_fixes_, tells_wheels_;  // they are not among what the order tells
  size_t order_at_ = 0, map_at_ = 0;
  size_t imu_at_ = 0, fix_at_ = 0, wheel_at_ = 0;
  TimeNs imu_arrival_ = 0, frame_arrival_ = 0;
};

}  // namespace pirvs::tools
