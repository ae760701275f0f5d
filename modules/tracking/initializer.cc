#include "modules/tracking/initializer.h"

#include "core/math/so3.h"
#include "modules/tracking/places.h"

namespace pirvs {
namespace {

// By how much an untracked device may turn from what the gyro says, and go.
constexpr double kUntracked_rad_s = 0.02, kUntracked_m_s = 1.0;

}  // namespace

void Initializer::configure(const Camera* cameras, int count, const ImuNoise& noise,
                            const FilterParams& filter, const TrackerParams& params,
                            const ImuHistory* history) {
  cameras_ = count;
  params_ = params;
  starter_.configure(cameras, noise, filter, params, history);
}

void Initializer::interrupt() {
  starter_.reset();
  last_pair_t_ = pairless_t_ = 0;
  R_BlBn_.setIdentity();
}

void Initializer::lost(const BodyState& state, const Mat6& error) {
  origin_ = state.T_WB;
  origin_t_ = state.t;
  origin_error_ = error;
  starter_.reset();
}

void Initializer::turn(const ImuSample& before, const ImuSample& now) {
  R_BlBn_ = R_BlBn_ * so3_exp(0.5 * (before.w_B + now.w_B) * to_seconds(now.t - before.t));
}

Mat3 Initializer::take_turn() {
  const Mat3 R_BlBn = R_BlBn_;
  if (starter_.idle()) origin_.R = orthonormalized(origin_.R * R_BlBn);
  R_BlBn_.setIdentity();
  return R_BlBn;
}

void Initializer::note_seen(TimeNs t, uint8_t seen) {
  if (seen == kBothSee || last_pair_t_ == 0) last_pair_t_ = t;
}

// Where both see, but for long nothing that is the same (a cap, a wall close by, an extrinsic that
// is wrong), the camera alone that follows more.
uint8_t Initializer::cameras_for(TimeNs t, uint8_t seen, const Associator& associator) const {
  const bool pairless =
      pairless_t_ != 0 && to_seconds(t - pairless_t_) > params_.start_mono_after_s;
  if (seen != kBothSee || !pairless) return seen;
  if (!starter_.idle() && start_cameras_ != kBothSee) return start_cameras_;
  return associator.lasting_tracks(0) >= associator.lasting_tracks(1) ? kLeftAlone : kRightAlone;
}

// A pair gives depth at once, so one camera alone is looked through only when the other stays away
// or is of no use.
Status Initializer::add_frame(TimeNs t, uint8_t seen_by, const StandstillDetector& standstill,
                              Keyframer& keyframer, Associator& associator) {
  const uint8_t seen = cameras_for(t, seen_by, associator);
  const bool alone = seen == kLeftAlone || seen == kRightAlone;
  const bool waits =
      cameras_ > 1 && seen == seen_by && to_seconds(t - last_pair_t_) < params_.start_mono_after_s;
  if (seen == 0 || (alone && waits)) return Status::kEmpty;
  if (!starter_.idle() && seen != start_cameras_) starter_.reset();
  start_cameras_ = seen;
  const Observations* observations = nullptr;
  if (starter_.wants_keyframe(t)) {
    keyframer.clear_pairs();
    if (!alone) keyframer.find_pairs(nullptr, associator);
    keyframer.observe(associator, observations_);
    observations = observations_;
  }
  if (alone) {
    const int c = seen == kRightAlone ? 1 : 0;
    const Status status = starter_.add_mono_frame(t, c, observations, standstill, origin_);
    if (status != Status::kEmpty) pairless_t_ = 0;  // pairs have their turn again
    return status;
  }
  const Status status = starter_.add_frame(t, associator.tracks(0), associator.tracks(1),
                                           observations, standstill, origin_);
  const bool none = status == Status::kStale && starter_.idle();
  if (!none) pairless_t_ = 0;
  if (none && pairless_t_ == 0) pairless_t_ = t;
  return status;
}

Mat6 Initializer::origin_error(TimeNs t) const {
  if (origin_t_ == 0) return Mat6::Zero();  // nothing ran before: it defines its own place
  const double gap_s = to_seconds(t - origin_t_);
  return origin_error_ + error_of_sigmas(kUntracked_rad_s * gap_s, kUntracked_m_s * gap_s);
}

}  // namespace pirvs
