// A link whose clock is the time of the newest pose or frame: that of a recording which is played
// as fast as possible, so that the same input gives the same bytes.
// In      open(): what Link::configure wants, and the feed; frame(): the time of each frame;
//         poll(): after each step. All from one core.
// Out     That of link(); nothing before the first frame.
// Errors  open: kFull: too many take poses.
// Cost    That of Link.
// Source  docs/adr/0003-lockstep-determinism.md.
#pragma once

#include "modules/link/link.h"
#include "modules/output/pose_feed.h"

namespace pirvs {

class ReplayLink {
 public:
  Status open(const LinkSetup& setup, const ImuNoise& noise, const LinkStack& stack,
              const LinkWire& wire, PoseFeed& feed);
  void frame(TimeNs t) { note(t); }
  void poll();
  void close();

  Link& link() { return link_; }
  const Link& link() const { return link_; }
  TimeNs now() const { return now_; }
  bool is_open() const { return feed_ != nullptr; }

 private:
  void note(TimeNs t) {
    if (t > now_) now_ = t;
  }

  Link link_;
  PoseFeed* feed_ = nullptr;
  int consumer_ = 0;
  TimeNs now_ = 0;  // nothing has come yet
};

}  // namespace pirvs
