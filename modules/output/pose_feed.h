// Poses from the predictor to a fixed number of consumers: link, recorder, viewer, pins.
// In      publish(), from the predictor's core.
// Out     next(): the oldest waiting pose; newest(): the last one, the others are skipped. Both
//         from the consumer's core alone, valid until its next call.
// Errors  attach: kFull. A consumer that is slow loses its own oldest poses, counted by lost(), and
//         delays nobody: a controller steers by the newest pose, and one that was taken
//         `kPosesKept` samples ago would be worse than none.
// Cost    publish ~30 ns a consumer (a copy of 1 kB); memory kPoseConsumersMax x 66 kB.
// Source  core/store/newest_ring.h.
#pragma once

#include "core/base/status.h"
#include "core/store/newest_ring.h"
#include "modules/output/pose.h"

namespace pirvs {

inline constexpr int kPoseConsumersMax = 1     // link
                                         + 1   // recorder
                                         + 1   // viewer
                                         + 1;  // pins
inline constexpr size_t kPosesKept = 64;       // 0.3 s at 200 Hz: more than the period of a viewer

class PoseFeed {
 public:
  // A consumer's number, from 0. From any core, at any time. The first pose is the next published.
  Result<int> attach();
  void detach(int consumer);

  void publish(const Pose& pose);

  [[nodiscard]] const Pose* next(int consumer);
  [[nodiscard]] const Pose* newest(int consumer);
  // Since attach().
  uint64_t lost(int consumer) const;

 private:
  enum class State : uint8_t { kFree, kTaken, kAttached };

  struct Consumer {
    std::atomic<State> state{State::kFree};
    uint64_t lost_before = 0;
    NewestRing<Pose, kPosesKept> ring;
  };

  Consumer consumers_[kPoseConsumersMax];
};

}  // namespace pirvs
