// What tracking does with the map as a whole: where it stands, another that is loaded, places of it
// that are seen again.
#include "modules/tracking/tracker.h"

namespace pirvs {

void Tracker::move_world(const SE3& T) {
  const SE3 before = place();
  initializer_.move_origin(T);
  keyframer_.move_last(T);
  if (running_) estimate_.carry_over(T);
  note_jump(before, place(), true);
}

void Tracker::continue_map(uint32_t sequence, uint16_t epoch) {
  keyframer_.continue_after(sequence);
  epochs_ = epochs_loaded_ = epoch;
  const MapSnapshot* snapshot = mailbox_->take();
  if (snapshot == nullptr) return;
  estimate_.set_map_error({snapshot->error, snapshot->state.T_WB.p});
  associator_.take(*snapshot, snapshot->state.T_WB, sequence);
}

void Tracker::continue_at(TimeNs t, const SE3& T_WB, double sigma_m) {
  constexpr double kHeading_rad = 0.2;
  const SE3 before = place();
  if (running_) {
    lose();
    health_.lost();
  }
  BodyState there;
  there.t = t;
  there.T_WB = T_WB;
  initializer_.lost(there, error_of_sigmas(kHeading_rad, sigma_m));
  note_jump(before, place(), true);
}

// A start that knew no place looks for the older map; mapping then carries over what it made since.
bool Tracker::try_join(TimeNs t) {
  const BodyState& state = estimate_.state();
  if (!recognise(t, PlaceRule::kOther, state.T_WB.R) || places_.found_is_planar(associator_)) {
    return false;
  }
  KeyframeMessage* message =
      keyframer_.begin(at_time(state, t), standstill_.at_rest(), epoch_, associator_);
  if (message == nullptr) return false;
  T_join_ = places_.found().T_WB * state.T_WB.inverse();
  message->join = true;
  message->joining = epoch_;
  message->T_join = T_join_;
  move(T_join_, message->state);
  message->epoch = epoch_ = places_.found().epoch;
  message->error = estimate_.map_error().cov + recognised_error();
  keyframer_.end(*message, state);
  place_known_ = joining_ = true;
  ++counters_.joins;
  return true;
}

// The way since an old place was off: mapping spreads that over it.
bool Tracker::try_close(TimeNs t) {
  const BodyState& state = estimate_.state();
  const LoopDecision loop =
      places_.test_loop(t, state.T_WB, estimate_.map_error(), drifted_after_, associator_);
  counters_.loops_implausible += loop.verdict == LoopDecision::Verdict::kImplausible ? 1 : 0;
  counters_.loops_held += loop.verdict == LoopDecision::Verdict::kHeld ? 1 : 0;
  if (loop.verdict != LoopDecision::Verdict::kCloses) return false;
  KeyframeMessage* message =
      keyframer_.begin(at_time(state, t), standstill_.at_rest(), epoch_, associator_);
  if (message == nullptr) return false;
  associator_.adopt(
      places_.found());  // only now: where nothing closes, tracks keep their own points
  keyframer_.observe(associator_, message->observations);
  message->close = true;
  message->off = loop.off;
  message->off_cov = loop.off_cov;
  message->closes_to = loop.closes_to;
  T_join_ = loop.T;
  keyframer_.end(*message, state);
  keyframer_.move_last(T_join_);
  joining_ = true;
  drifted_after_ = 0;
  ++counters_.loops;
  return true;
}

}  // namespace pirvs
