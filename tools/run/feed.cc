#include "tools/run/feed.h"

#include <utility>

namespace pirvs::tools {

Feed::Feed(const Recording& recording, const std::vector<Fault>& faults,
           std::function<void(size_t played)> on_frame)
    : recording_(recording),
      faults_(faults, recording),
      player_(recording),
      on_frame_(std::move(on_frame)) {}

bsp::RecordingSource Feed::source() { return {this, next_imu, next_frame, release_frame}; }

bool Feed::next_imu(void* context, ImuSample& out) {
  Feed& feed = *static_cast<Feed*>(context);
  while (feed.imu_at_ < feed.recording_.imu.size()) {
    out = feed.recording_.imu[feed.imu_at_++];
    if (feed.faults_.pass(out)) return true;
  }
  return false;
}

bool Feed::next_frame(void* context, StereoFrame& out) {
  Feed& feed = *static_cast<Feed*>(context);
  while (const StereoFrame* const frame = feed.player_.front()) {
    out = *frame;
    if (feed.faults_.pass(out)) return true;
    feed.player_.pop();
  }
  return false;
}

void Feed::release_frame(void* context) {
  Feed& feed = *static_cast<Feed*>(context);
  feed.player_.pop();
  if (feed.on_frame_) feed.on_frame_(feed.player_.frames_played());
}

}  // namespace pirvs::tools
