// Predictor, feed and latency as one: fused states and IMU samples in, poses to all consumers out.
// In      fuse(): after every frame; replace(): when the state was changed otherwise, by a command
//         or an interruption; both from one core at a time. add_imu(): every good sample at once;
//         interrupt(): time does not go on from the last sample; doubt_stamps(): one sensor's
//         stamps may be wrong; these from the door's core.
// Out     feed(), to attach to; latency(), from any core.
// Errors  counted by the predictor.
// Cost    that of Predictor::add_imu and PoseFeed::publish. 0.4 MB.
// Source  docs/architecture.md, "One feed out".
#pragma once

#include "modules/output/latency.h"
#include "modules/output/pose_feed.h"
#include "modules/output/predictor.h"

namespace pirvs {

class Output {
 public:
  void configure(const ImuNoise& noise, double cov_scale, TimeNs bridge) {
    predictor_.configure(noise, cov_scale, bridge);
  }
  // The clock of the sensors' stamps. Without one (a replay as fast as possible) poses have no
  // time of publication, and no latency is measured. Before the first sample.
  void set_clock(TimeNs (*now)()) { now_ = now; }

  void fuse(const FusedState& fused) {
    predictor_.fuse(fused);
    if (now_ != nullptr && fused.running) latency_.exposure_to_fused.add(now_() - fused.state.t);
  }
  void replace(const FusedState& state) { predictor_.fuse(state); }
  void interrupt() { predictor_.interrupt(); }
  void doubt_stamps(bool in_doubt) { predictor_.doubt_stamps(in_doubt); }
  void add_imu(const ImuSample& sample) {
    if (!predictor_.add_imu(sample, pose_)) return;
    if (now_ != nullptr) {
      pose_.t_published = now_();
      latency_.imu_to_pose.add(pose_.t_published - sample.t);
    }
    feed_.publish(pose_);
  }

  PoseFeed& feed() { return feed_; }
  const Latency& latency() const { return latency_; }
  const Predictor& predictor() const { return predictor_; }

 private:
  TimeNs (*now_)() = nullptr;
  Predictor predictor_;
  Pose pose_;
  PoseFeed feed_;
  Latency latency_;
};

}  // namespace pirvs
