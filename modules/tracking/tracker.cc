#include "modules/tracking/tracker.h"

#include <cmath>
#include <new>

#include "core/base/assert.h"
#include "core/math/so3.h"

namespace pirvs {
namespace {

constexpr int kFollowed = 4;  // tracks of known points that a pose can stand on

// What the IMU of a body at rest should say.
StandstillDetector::Expected expected_at_rest(const BodyState& state) {
  const Vec3 up_B = state.T_WB.R.transpose() * Vec3(0, 0, kGravity_m_s2);
  return {true, state.b_g, up_B + state.b_a};
}

double sigma_px(const FilterParams& params, bool at_rest) {
  return params.sigma_px * (at_rest ? params.standstill_px_scale : 1);
}

}  // namespace

void Tracker::configure(const Camera* cameras, int count, const ImuNoise& noise,
                        const TrackingParams& params, Frontend* frontends, KeyframeRing* keyframes,
                        MapMailbox* map) {
  params_ = params;
  noise_ = noise;
  mailbox_ = map;
  standstill_.configure(params.standstill);
  associator_.configure(cameras, count, params.matching, frontends);
  estimate_.configure(cameras, noise, params.filter, params.tracker.cov_scale, &history_);
  places_.configure(cameras, count, noise, params.filter, params.matching, params.tracker);
  keyframer_.configure(cameras, noise, params.tracker, params.stereo, keyframes);
  initializer_.configure(cameras, count, noise, params.filter, params.tracker, &history_);
  health_.configure(params.health);
  configure_wheels(WheelCalibration{});
}

void Tracker::configure_wheels(const WheelCalibration& wheels) {
  odometry_.configure(wheels, params_.wheels);
  estimate_.configure_wheels(wheels.T_BV, params_.wheels, &wheels_);
  keyframer_.configure_wheels(wheels.T_BV, params_.wheels);
  initializer_.configure_wheels(wheels.T_BV, params_.wheels, &wheels_);
}

void Tracker::forget() {
  const TrackingCounters counted = counters_;
  const CounterArray<StereoLoss> pairs = keyframer_.stereo().losses();
  this->~Tracker();  // in place: no stack could hold another
  new (this) Tracker(counted, pairs);
}

void Tracker::add_imu(const ImuSample& measured) {
  const ImuSample sample = in_doubt_ ? doubted(measured) : measured;
  const bool follows = !history_.empty();
  const ImuSample before = follows ? history_.newest() : sample;
  history_.add(sample);
  vibration_.add(sample);
  force_B_ = sample.f_B;
  if (running_) {
    estimate_.propagate(sample);
    if (follows) keyframer_.integrate(before, sample);
  } else if (follows) {
    initializer_.turn(before, sample);
  }
}

// What slips is not used for a while: it slips a little before and after it is seen to.
void Tracker::add_wheel(const WheelSample& sample) {
  if (params_.wheels.use < 0.5f || history_.empty()) return;
  WheelVelocity velocity;
  const Status status = odometry_.take(sample, velocity);
  if (status == Status::kEmpty) return;
  const TimeNs now = history_.newest().t;
  constexpr TimeNs kApart_ns_max = 200'000'000;
  if (status != Status::kOk || std::abs(now - velocity.t) > kApart_ns_max) {
    ++counters_.wheels_refused;
    return;
  }
  bool slips = now < slips_until_ || in_doubt_;
  if (running_ && !slips) {
    const WheelVerdict verdict = estimate_.update_wheel(velocity);
    slips = verdict == WheelVerdict::kSlips;
    counters_.wheels_skidding += verdict == WheelVerdict::kSkids ? 1 : 0;
    if (slips) slips_until_ = now + from_seconds(params_.wheels.slip_hold_s);
  }
  (slips ? counters_.wheels_slipping : counters_.wheels_used) += 1;
  wheels_.add({now, velocity, slips});
  if (running_) keyframer_.note_wheels(velocity, slips);
}

Vec3 Tracker::prepare(uint32_t finished) {
  const ImuNoise noise = vibration_.on_top_of(noise_);
  estimate_.set_noise(noise);
  keyframer_.set_noise(noise);
  initializer_.set_noise(noise);
  if (!running_) {
    keyframer_.note_mapped(finished);
    associator_.predict(initializer_.take_turn());
    return -force_B_;
  }
  take_snapshot();
  keyframer_.note_mapped(associator_.map().keyframe());
  const SE3& T_WB = estimate_.state().T_WB;
  associator_.predict(estimate_.T_WB_last_frame(), T_WB);
  return T_WB.R.transpose() * Vec3(0, 0, -kGravity_m_s2);
}

// After an adjustment the filter goes on from the refined keyframe: its state and covariance there,
// then what was sensed and seen since.
void Tracker::take_snapshot() {
  const MapSnapshot* snapshot = mailbox_->take();
  if (snapshot == nullptr) return;
  ++counters_.snapshots;
  const SE3 T_WB_before = estimate_.state().T_WB;
  follow_level(snapshot->leveled);
  const bool newest = snapshot->keyframe == keyframer_.sent();
  const bool joined = joining_ && newest;
  if (joined) {  // that map's frame from now on, should the adjustment fail to say so itself
    estimate_.carry_over(T_join_);
    joining_ = false;
  }
  // One that mapping has finished after the next was sent serves as well, while no other frame of
  // the map is about to be taken.
  const bool known = newest || (!joining_ && recent_.covers(snapshot->state.t));
  const bool restarted =
      snapshot->adjusted && known && estimate_.restart(snapshot->state, snapshot->cov);
  if (!newest || (snapshot->adjusted && !restarted)) ++counters_.snapshots_late;
  if (restarted) {
    if (newest) keyframer_.refine(snapshot->state);
    advance_to_now();  // the map is looked at from there
  }
  estimate_.set_map_error({snapshot->error, snapshot->state.T_WB.p});
  associator_.take(*snapshot, estimate_.state().T_WB, keyframer_.sent());
  if (restarted && recent_.newer_than(snapshot->state.t)) fuse_again(*snapshot);
  note_jump(T_WB_before, estimate_.state().T_WB, joined);
}

// From the refined keyframe, with the frames since then, now against the refined map. Tracks that
// have become landmarks count in all of them.
void Tracker::fuse_again(const MapSnapshot& snapshot) {
  const bool restarted = estimate_.restart(snapshot.state, snapshot.cov);
  PIRVS_ASSERT(restarted);  // it was before
  for (uint32_t frame = recent_.begin(); frame < recent_.end(); ++frame) {
    const TimeNs t = recent_.time(frame);
    if (t <= snapshot.state.t) continue;
    estimate_.advance(t);
    constexpr bool kAtRest = false;  // of a frame at rest nothing is noted
    (void)estimate_.update(associator_.collect(sigma_px(params_.filter, kAtRest), recent_, frame),
                           true);
  }
  advance_to_now();
}

void Tracker::advance_to_now() {
  estimate_.advance(last_frame_t_);
  estimate_.end_frame();
  estimate_.advance(history_.newest().t);
}

// Mapping has tilted the map, and what stands in it goes along.
void Tracker::follow_level(const SE3& leveled) {
  const SE3 T = leveled * associator_.map().leveled().inverse();
  if (so3_log(T.R).norm() < 1e-9) return;
  keyframer_.move_last(T);
  initializer_.move_origin(T);
  T_join_ = T * T_join_ * T.inverse();
  if (running_) estimate_.carry_over(T);
}

TimeNs Tracker::correct_time() {
  const bool wanted = params_.tracker.estimate_time > 0.5f && running_;
  return wanted ? estimate_.self_calibration().correct_time() : 0;
}

void Tracker::match() {
  if (!running_) return;
  // Nothing is followed any more, and the pose is too uncertain to tell what is near from what only
  // looks like it.
  if (associator_.known_tracks() < kFollowed && estimate_.unsure()) searching_ = true;
  counters_.matched_by_projection +=
      static_cast<uint32_t>(associator_.match({estimate_.state().T_WB, estimate_.pose_cov()}));
}

FrameResult Tracker::frame(TimeNs t, uint8_t present) {
  FrameResult result;
  const uint32_t sent = keyframer_.sent(), dropped = keyframer_.dropped();
  ++counters_.frames;
  const double dt_s = last_frame_t_ == 0 ? 0.0 : to_seconds(t - last_frame_t_);
  compare_turns(t, present, dt_s);
  last_frame_t_ = t;
  const uint8_t seen = associator_.seeing(present);
  associator_.vote(present, dt_s, standstill_);
  standstill_.judge(
      history_, dt_s,
      running_ ? expected_at_rest(estimate_.state()) : StandstillDetector::Expected{});
  result.at_rest = standstill_.at_rest();
  if (result.at_rest) associator_.drop_movers(standstill_);
  initializer_.note_seen(t, seen);
  if (running_) {
    update(t, seen, result);
    if (running_) maybe_keyframe(t, seen, result);
  } else {
    start(t, seen, result);
  }
  counters_.keyframes += keyframer_.sent() - sent;
  counters_.keyframes_dropped += keyframer_.dropped() - dropped;
  if (!running_) return result;
  if (params_.wheels.estimate_scale > 0.5f) {
    odometry_.enlarge(estimate_.self_calibration().correct_scale());
  }
  estimate_.end_frame();
  note_recent(t, present, result.at_rest);
  if (!joining_) pose_epoch_ = epoch_;
  result.has_pose = true;
  ++counters_.frames_with_pose;
  return result;
}

// At rest nothing is fused again: the samples count there as measurements of rest.
void Tracker::note_recent(TimeNs t, uint8_t present, bool at_rest) {
  if (at_rest) {
    recent_.clear();
    return;
  }
  recent_.add(t);
  for (int c = 0; c < kCamerasMax; ++c) {
    if ((present >> c & 1) != 0) recent_.note(c, associator_.tracks(c));
  }
}

// The filter's step with what was matched, and what health says of it.
void Tracker::update(TimeNs t, uint8_t seen, FrameResult& result) {
  const SE3 T_WB_predicted = estimate_.state().T_WB;
  const bool at_rest = standstill_.at_rest();
  estimate_.stand_still(standstill_);
  if (at_rest) ++counters_.standstill_frames;
  Correspondences& correspondences =
      associator_.collect(sigma_px(params_.filter, at_rest), standstill_);
  result.correspondences = static_cast<int>(correspondences.size());
  result.accepted = fuse(correspondences);
  if (result.accepted >= static_cast<int>(params_.health.matches_min)) {
    located_ = true;
    light_since_ = 0;
    if (seen == kBothSee && !at_rest) compare_cameras(t, correspondences);
  } else if (seen == 0 || !located_) {
    light_since_ = 0;
  } else {
    if (light_since_ == 0) light_since_ = t;
    relocalize(t, result);
  }
  for (const Correspondence& k : correspondences) counters_.gates.add(k.gate);
  const int cells = associator_.occupied_cells();
  counters_.tracks_dropped +=
      static_cast<uint32_t>(associator_.drop_misfits(params_.tracker.misses_max));
  if (at_rest) estimate_.note_rest();
  note_jump(T_WB_predicted, estimate_.state().T_WB, result.recognised);
  result.health_changed = health_.update(evidence(t, result, cells));
  if (health_.state() == HealthState::kLost) lose();
}

void Tracker::compare_cameras(TimeNs t, const Correspondences& correspondences) {
  estimate_.compare(correspondences, pair_check_);
  const SelfCalibration::Estimate both = estimate_.self_calibration().estimate();
  counters_.cameras_left_out += pair_check_.judge(t, both.time_s, both.turn_B) ? 1 : 0;
}

void Tracker::compare_turns(TimeNs t, uint8_t present, double dt_s) {
  constexpr double kGap_s = 0.2;
  if (!(dt_s > 0 && dt_s < kGap_s) || present == 0 || !history_.covers(last_frame_t_)) return;
  const Vec3 b_g = running_ ? estimate_.state().b_g : Vec3::Zero();
  const Preintegration motion = integrate(history_, last_frame_t_, t, b_g, Vec3::Zero(), noise_);
  associator_.compare(present, so3_log(motion.dR), dt_s, turn_check_);
}

// Stereo gives wrong depths where the cameras stand turned other than calibrated: one of them goes
// on alone, before a start as well as after it.
bool Tracker::leave_out_turned(TimeNs t) {
  const EpipolarTurn& turn = keyframer_.stereo().turn();
  if (!turn.disagrees()) return false;
  PairCheck::Verdict pair;
  pair.turn_B = turn.turn_B();
  const SelfCalibration::Estimate both = estimate_.self_calibration().estimate();
  pair_check_.leave_out(t, pair, both.time_s, both.turn_B);
  keyframer_.forget_turn();
  ++counters_.cameras_left_out;
  return true;
}

// After dead reckoning a match may be wrong and fit all the same: many have to agree.
int Tracker::fuse(Correspondences& correspondences) {
  if (!searching_ || standstill_.at_rest()) return estimate_.update(correspondences);
  const int wanted = static_cast<int>(params_.health.matches_min);
  const int accepted = estimate_.update_if_agreed(correspondences, wanted);
  searching_ = accepted == 0;
  drift_told_ = drift_told_ && searching_;
  if (searching_ && correspondences.size() > 0) {
    ++counters_.disagreements;
    associator_.forget_landmarks();
  }
  return accepted;
}

FrameEvidence Tracker::evidence(TimeNs t, const FrameResult& result, int cells) const {
  const BodyState& state = estimate_.state();
  FrameEvidence out;
  out.t = t;
  out.accepted = result.accepted;
  out.rejected = result.correspondences - result.accepted;
  out.cells = cells;
  out.position_sigma_m = std::sqrt(estimate_.pose_cov().diagonal().tail<3>().maxCoeff());
  out.at_rest = standstill_.at_rest();
  out.speed_m_s = state.v_WB.norm();
  out.accel_bias_m_s2 = state.b_a.norm();
  out.gyro_bias_rad_s = state.b_g.norm();
  out.moved_along = standstill_.moved_along();
  out.cameras_disagree = pair_check_.in_doubt();
  out.turns_against = turn_check_.against();
  return out;
}

// There is light again, but what is seen is not where dead reckoning expects it.
void Tracker::relocalize(TimeNs t, FrameResult& result) {
  if (!recognise(t, PlaceRule::kSame, estimate_.state().T_WB.R)) return;
  if (!estimate_.plausible(places_.found().T_WB, recognised_error())) {
    ++counters_.recognitions_implausible;  // a place that looks the same
    return;
  }
  estimate_.relocate(places_.found().T_WB, kRecognised_rad, kRecognised_m);
  associator_.forget_landmarks();
  associator_.adopt(places_.found());
  Correspondences& correspondences =
      associator_.collect(sigma_px(params_.filter, standstill_.at_rest()), standstill_);
  result.correspondences = static_cast<int>(correspondences.size());
  result.accepted = estimate_.update(correspondences);
  result.recognised = true;
  searching_ = drift_told_ = false;
  drifted_after_ = 0;
  light_since_ = 0;
}

bool Tracker::recognise(TimeNs t, PlaceRule rule, const Mat3& R_WB) {
  const PlaceAnswer answer = places_.recognise(t, rule, R_WB, associator_);
  counters_.recognitions += answer == PlaceAnswer::kFound ? 1 : 0;
  counters_.recognitions_failed += answer == PlaceAnswer::kUnknown ? 1 : 0;
  return answer == PlaceAnswer::kFound;
}

void Tracker::note_jump(const SE3& before, const SE3& after, bool certain) {
  const double turn_rad = so3_log(before.R.transpose() * after.R).norm();
  if (health_.note_jump((after.p - before.p).norm(), turn_rad, certain)) ++counters_.jumps;
}

// The map stays: the next start looks for it. It continues this place; where the run was hopeless,
// that of its own start.
void Tracker::lose() {
  ++counters_.losses;
  running_ = located_ = searching_ = drift_told_ = false;
  drifted_after_ = 0;
  recent_.clear();
  const BodyState& state = estimate_.state();
  if (health_.denied()) {
    ++counters_.losses_hopeless;
    initializer_.lost(begin_, begin_error_);
    return;
  }
  initializer_.lost(state,
                    estimate_.map_error().cov + error_of_pose(state.T_WB.R, estimate_.pose_cov()));
}

void Tracker::interrupt() {
  if (running_) {
    lose();
    health_.lost();
  }
  initializer_.interrupt();
  standstill_.reset();
  estimate_.end_rest();
  places_.reset();
  history_.clear();
  vibration_.reset();
  wheels_.clear();
  last_frame_t_ = light_since_ = 0;
}

// A start continues where the last track ended, unless the map knows better.
void Tracker::start(TimeNs t, uint8_t seen, FrameResult& result) {
  const Status status = initializer_.add_frame(t, seen, standstill_, keyframer_, associator_);
  if (leave_out_turned(t)) {
    initializer_.fail();
    return;
  }
  if (status == Status::kStale) ++counters_.start_failures;
  if (status != Status::kOk) return;
  Starter& starter = initializer_.starter();
  Mat6 error = Mat6::Zero();  // of the place; the first start defines it
  places_.hurry();
  place_known_ = associator_.map().points() == 0;
  if (!place_known_ && recognise(t, PlaceRule::kSame, starter.state().T_WB.R) &&
      !places_.found_is_planar(associator_)) {
    starter.move(places_.found().T_WB * starter.state().T_WB.inverse());
    error = estimate_.map_error().cov + recognised_error();
    place_known_ = true;
    epoch_ = places_.found().epoch;
    ++counters_.joins;
    result.joined = true;
  } else {
    epoch_ = ++epochs_;
    if (!place_known_) error = initializer_.origin_error(t);
  }
  if (!keyframer_.send_start(starter.keyframes(), epoch_, error, associator_)) {
    initializer_.fail();  // mapping is behind: try again with the next frames
    return;
  }
  estimate_.set_map_error({error, starter.state().T_WB.p});
  estimate_.begin(starter.state(), starter.cov());
  begin_ = at_time(starter.state(), t);
  begin_error_ = error + error_of_pose(begin_.T_WB.R, estimate_.pose_cov());
  running_ = true;
  joining_ = false;
  light_since_ = 0;
  health_.started(t);
  note_jump(initializer_.origin(), estimate_.state().T_WB, true);
  ++counters_.starts;
  result.started = true;
  result.started_at_rest = starter.at_rest();
  result.health_changed = true;
}

void Tracker::maybe_keyframe(TimeNs t, uint8_t seen, FrameResult& result) {
  const bool alone = seen == kLeftAlone || seen == kRightAlone;
  const bool at_rest = standstill_.at_rest();
  const bool no_depth = alone && associator_.map().own_points() == 0 && at_rest;
  const bool waits =
      light_since_ != 0 && to_seconds(t - light_since_) < params_.tracker.recognise_wait_s;
  const bool blind = !at_rest && result.accepted < static_cast<int>(params_.health.matches_min);
  const bool noise = blind && associator_.lasting_tracks() < kFollowed;
  if (seen == 0 || noise || joining_ || waits || in_doubt_) return;
  const SE3& T_WB = estimate_.state().T_WB;
  const int camera = seen == kRightAlone ? 1 : 0;
  if (!(no_depth ? keyframer_.rest_due(t)
                 : !at_rest && keyframer_.due(t, T_WB, camera, associator_))) {
    return;
  }
  keyframer_.clear_pairs();
  if (!alone) keyframer_.find_pairs(&T_WB, associator_);
  if (!alone && leave_out_turned(t)) return;
  result.keyframe = true;
  result.joined = !place_known_ && try_join(t);
  if (result.joined) return;
  result.closed = try_close(t);
  if (result.closed) return;
  const uint32_t newest = keyframer_.sent();
  KeyframeMessage* message =
      keyframer_.begin(at_time(estimate_.state(), t), at_rest, epoch_, associator_);
  if (message == nullptr) return;
  message->restart = message->renew = no_depth;
  if (searching_ && !drift_told_) {
    message->drift = error_of_pose(estimate_.state().T_WB.R, estimate_.pose_cov());
    drift_told_ = true;
    drifted_after_ = newest;
  }
  keyframer_.end(*message, estimate_.state());
}

}  // namespace pirvs
