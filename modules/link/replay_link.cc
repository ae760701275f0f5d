#include "modules/link/replay_link.h"

namespace pirvs {

Status ReplayLink::open(const LinkSetup& setup, const ImuNoise& noise, const LinkStack& stack,
                        const LinkWire& wire, PoseFeed& feed) {
  const Result<int> consumer = feed.attach();
  if (!consumer.ok()) return consumer.status();
  consumer_ = consumer.value();
  feed_ = &feed;
  now_ = 0;
  link_.configure(setup, noise, stack, wire);
  return Status::kOk;
}

void ReplayLink::poll() {
  if (feed_ == nullptr) return;
  while (const Pose* const pose = feed_->next(consumer_)) {
    note(pose->state.t);
    link_.pose(*pose);
  }
  if (now_ > 0) link_.poll(now_);
}

void ReplayLink::close() {
  if (feed_ == nullptr) return;
  poll();
  feed_->detach(consumer_);
  feed_ = nullptr;
}

}  // namespace pirvs
