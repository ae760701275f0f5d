// The pose at each IMU sample, at once: the newest fused state, integrated over the samples since.
// In      fuse(): the state after each frame, from tracking's core. add_imu(): every good sample in
//         order, from the door's core, as soon as the door has accepted it.
// Out     a Pose at the sample's time but for t_published. While stamps are in doubt, the IMU's
//         noise is inflated as in the filter, so that the covariance grows, and confidence is
//         limited; not at rest, where wrong stamps do no harm.
// Errors  add_imu gives false when there is nothing to give: tracking does not run; time ran back
//         or stood still for longer than `bridge`, and no state was fused since; the fused state is
//         older than kHistory samples (anchors_missed); the result is not finite (not_finite).
// Cost    add_imu ~3 us, x86-64. The first sample after a fused state integrates anew all samples
//         since the frame: 3 us times (latency of tracking / IMU period), 1.6 ms with a full
//         history. fuse: one copy of 2 kB.
// Source  the output predictor of PX4's ekf2, here with the filter's own propagation in place of a
//         complementary filter: the prediction at a frame's time is the filter's.
#pragma once

#include <atomic>

#include "core/store/mailbox.h"
#include "modules/imu/propagation.h"
#include "modules/output/pose.h"

namespace pirvs {

class Predictor {
 public:
  // `noise`: the filter's. `cov_scale`: by which covariances are scaled that are given out, so that
  // they grow as the filter's do. `bridge`: a longer gap between samples cannot be integrated over.
  void configure(const ImuNoise& noise, double cov_scale, TimeNs bridge);

  void fuse(const FusedState& fused);
  // Time does not go on from the last sample, however small the step is. The door's core.
  void interrupt();
  // Of the samples from the next one on. The door's core.
  void doubt_stamps(bool in_doubt) { in_doubt_ = in_doubt; }
  [[nodiscard]] bool add_imu(const ImuSample& sample, Pose& out);

  // From any core.
  uint32_t anchors_missed() const { return anchors_missed_.load(std::memory_order_relaxed); }
  uint32_t not_finite() const { return not_finite_.load(std::memory_order_relaxed); }

 private:
  static constexpr size_t kHistory = 512;  // 2.5 s at 200 Hz, 0.5 s at 1 kHz

  const ImuSample& at(size_t i) const { return history_[i % kHistory]; }
  void remember(const ImuSample& sample);
  bool anchor(const FusedState& fused);
  bool in_doubt() const { return in_doubt_ && !fused_.at_rest; }
  bool is_finite() const;
  void fill(Pose& out) const;

  ImuNoise noise_;
  TimeNs bridge_ = 0;
  Mailbox<FusedState> mailbox_;

  // The door's core alone from here on. Samples [begin_, end_) are kept, by number since the start.
  ImuSample history_[kHistory];
  size_t begin_ = 0, end_ = 0;
  bool anchored_ = false, in_doubt_ = false;
  FusedState fused_;  // state and cov: at the newest sample
  TimeNs t_frame_ = 0;
  std::atomic<uint32_t> anchors_missed_{0}, not_finite_{0};
};

}  // namespace pirvs
