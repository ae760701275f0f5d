#include "modules/output/pose_feed.h"

#include "core/base/assert.h"

namespace pirvs {

Result<int> PoseFeed::attach() {
  for (int i = 0; i < kPoseConsumersMax; ++i) {
    Consumer& c = consumers_[i];
    State expected = State::kFree;
    if (!c.state.compare_exchange_strong(expected, State::kTaken)) continue;
    while (c.ring.take() != nullptr) continue;  // what the consumer before has left
    c.lost_before = c.ring.lost();
    c.state.store(State::kAttached);
    return i;
  }
  return Status::kFull;
}

void PoseFeed::detach(int consumer) {
  PIRVS_ASSERT(consumer >= 0 && consumer < kPoseConsumersMax);
  consumers_[consumer].state.store(State::kFree);
}

void PoseFeed::publish(const Pose& pose) {
  for (Consumer& c : consumers_) {
    if (c.state.load(std::memory_order_acquire) != State::kAttached) continue;
    c.ring.back() = pose;
    c.ring.publish();
  }
}

const Pose* PoseFeed::next(int consumer) {
  PIRVS_ASSERT(consumer >= 0 && consumer < kPoseConsumersMax);
  PIRVS_ASSERT(consumers_[consumer].state.load() == State::kAttached);
  return consumers_[consumer].ring.take();
}

const Pose* PoseFeed::newest(int consumer) {
  const Pose* last = nullptr;
  while (const Pose* pose = next(consumer)) last = pose;
  return last;
}

uint64_t PoseFeed::lost(int consumer) const {
  PIRVS_ASSERT(consumer >= 0 && consumer < kPoseConsumersMax);
  const Consumer& c = consumers_[consumer];
  return c.ring.lost() - c.lost_before;
}

}  // namespace pirvs
