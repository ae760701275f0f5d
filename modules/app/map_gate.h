// Says which of mapping's results a frame may use. Free: whatever is there when the frame begins,
// as on a device. Lagging: those of keyframes sent so many frames before, neither more nor fewer,
// so that a mapper of any speed gives the same bytes. Following: as a recorded run had them.
// In      each frame, with the newest keyframe that tracking has sent.
// Out     limit(): mapping may finish this keyframe, none after it. ready(): the frame may begin.
// Errors  none.
// Cost    none to speak of. limit() may be asked on any core, the rest belongs to the door's.
// Source  own; docs/adr/0003-lockstep-determinism.md.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "core/base/assert.h"

namespace pirvs {

// Of a recorded run: the newest keyframe that mapping had finished when the next frame began.
// False: not known.
struct MapDecisions {
  void* context = nullptr;
  bool (*next)(void* context, uint32_t& keyframe) = nullptr;
};

class MapGate {
 public:
  static constexpr int kFree = -1;
  static constexpr int kLagMax = 32;

  // From the next frame on, as long as it has an answer.
  void follow(const MapDecisions& decisions) { decisions_ = decisions; }
  // kFree, or 0 to kLagMax frames.
  void configure(int lag) {
    PIRVS_ASSERT(lag >= kFree && lag <= kLagMax);
    lag_ = lag;
    restart();
  }
  // Keyframes are counted from the first again.
  void restart() {
    frames_ = 0;
    limit_.store(lag_ == kFree ? UINT32_MAX : 0, std::memory_order_release);
  }
  // A frame is about to begin; `sent`: the newest keyframe so far.
  void frame(uint32_t sent) {
    uint32_t keyframe = 0;
    if (decisions_.next != nullptr && decisions_.next(decisions_.context, keyframe)) {
      // A recording that began in the midst of a run may name keyframes that are not there.
      return limit_.store(std::min(keyframe, sent), std::memory_order_release);
    }
    if (lag_ == kFree) return open();
    sent_[frames_ % (kLagMax + 1)] = sent;
    const uint32_t then = frames_ - static_cast<uint32_t>(lag_);
    if (frames_ >= static_cast<uint32_t>(lag_)) {
      limit_.store(sent_[then % (kLagMax + 1)], std::memory_order_release);
    }
    ++frames_;
  }
  // Until the next frame, mapping finishes what it has.
  void open() { limit_.store(UINT32_MAX, std::memory_order_release); }

  uint32_t limit() const { return limit_.load(std::memory_order_acquire); }
  // `finished`: the newest keyframe that mapping has done.
  bool ready(uint32_t finished) const { return limit() == UINT32_MAX || finished >= limit(); }

 private:
  MapDecisions decisions_;
  int lag_ = kFree;
  uint32_t frames_ = 0;
  uint32_t sent_[kLagMax + 1] = {};
  std::atomic<uint32_t> limit_{UINT32_MAX};
};

}  // namespace pirvs
