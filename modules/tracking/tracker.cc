#include "modules/tracking/tracker.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "core/base/assert.h"
#include "core/math/so3.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr uint8_t kLeftAlone = 1, kRightAlone = 2, kBoth = 3;  // cameras, a bit each
constexpr size_t kTracksSeeing = 8;                            // fewer: the camera sees nothing
constexpr float kDoubt_s = 0.2f;  // in doubt, a sample says no more than a line over such a gap
constexpr double kRecognised_rad = 0.02, kRecognised_m = 0.05;  // sigma of a recognised pose
// A recognised place is not better known than this; a loop that is off by less is closed already.
constexpr double kLocated_rad = 0.002, kLocated_m = 0.01;
constexpr double kLoopChi2_max = 18.5;  // 4 dof, 99.9 %
// By how much an untracked device may turn from what the gyro says, and go.
constexpr double kUntracked_rad_s = 0.02, kUntracked_m_s = 1.0;

Mat6 error_of_sigmas(double sigma_rad, double sigma_m) {
  Vec6 sigma;
  sigma << Vec3::Constant(sigma_rad), Vec3::Constant(sigma_m);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

void Tracker::configure(const Camera* cameras, int count, const ImuNoise& noise,
                        const TrackingParams& params, KeyframeRing* keyframes, MapMailbox* map) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  cameras_ = count;
  noise_ = noise;
  params_ = params;
  keyframes_ = keyframes;
  mailbox_ = map;
  filter_.configure(cameras, noise, params.filter);
  locator_.configure(cameras, noise, params.filter);
  starter_.configure(cameras, noise, params.filter, params.tracker);
  stereo_.configure(cameras[0], cameras[1], params.stereo);
  health_.configure(params.health);
  standstill_.configure(params.standstill);
  recogniser_.configure(cameras, count, params.matching);
  view_.clear();
}

void Tracker::add_imu(const ImuSample& measured) {
  ImuSample sample = measured;
  if (in_doubt_ && sample.gap_s < kDoubt_s) sample.gap_s = kDoubt_s;
  standstill_.add_imu(sample);
  history_[history_size_++ % kHistory] = sample;
  if (running_) {
    filter_.propagate(sample);
    if (has_imu_) {
      since_keyframe_.add(last_imu_.w_B, last_imu_.f_B, sample.w_B, sample.f_B,
                          to_seconds(sample.t - last_imu_.t),
                          bridged(noise_, static_cast<double>(sample.gap_s)));
    }
  } else {
    starter_.add_imu(sample);
    if (has_imu_) {
      const double dt_s = to_seconds(sample.t - last_imu_.t);
      R_BlBn_ = R_BlBn_ * so3_exp(0.5 * (last_imu_.w_B + sample.w_B) * dt_s);
    }
  }
  last_imu_ = sample;
  has_imu_ = true;
}

Mat15 Tracker::cov() const {
  const Mat15x6 G = rigid_motion(filter_.state(), map_error_at_);
  return params_.tracker.cov_scale * (filter_.cov() + G * map_error_ * G.transpose());
}

void Tracker::note_place(const Mat6& error, const Vec3& at) {
  map_error_ = error;
  map_error_at_ = at;
}

Vec3 Tracker::prepare(Frontend* frontends) {
  if (!running_) {
    for (int c = 0; c < kCamerasMax; ++c) {
      const Mat3 R_BC = camera_[c].T_BC.R;
      frontends[c].predict(R_BC.transpose() * R_BlBn_.transpose() * R_BC);
    }
    if (starter_.idle()) origin_.R = orthonormalized(origin_.R * R_BlBn_);
    R_BlBn_.setIdentity();
    return -last_imu_.f_B;
  }
  take_snapshot(frontends);
  const SE3& T_WB = filter_.state().T_WB;
  for (int c = 0; c < kCamerasMax; ++c) {
    const SE3 T_CW = (T_WB * camera_[c].T_BC).inverse();
    const SE3 T_CW_last = (T_WB_last_frame_ * camera_[c].T_BC).inverse();
    frontends[c].predict(T_CW.R * T_CW_last.R.transpose());
    const Tracks& tracks = frontends[c].tracks();
    for (size_t i = 0; i < tracks.size(); ++i) {
      Track& track = frontends[c].track(i);
      const MapPoint* point = view_.find(landmarks_[c].get(track));
      Vec2 before, now;
      if (point == nullptr || !camera_[c].project(T_CW_last * point->p_W, before) ||
          !camera_[c].project(T_CW * point->p_W, now)) {
        continue;
      }
      // The predicted motion of the point, from where the track is: its own offset stays.
      track.x_pred = track.x + static_cast<float>(now.x() - before.x());
      track.y_pred = track.y + static_cast<float>(now.y() - before.y());
    }
  }
  return T_WB.R.transpose() * Vec3(0, 0, -kGravity_m_s2);
}

// After an adjustment the filter goes on from the refined keyframe: its state and covariance there,
// then the samples since. The frames between are in the refined map's favour already.
void Tracker::take_snapshot(Frontend* frontends) {
  const MapSnapshot* snapshot = mailbox_->take();
  if (snapshot == nullptr) return;
  ++counters_.snapshots;
  const SE3 T_WB_before = filter_.state().T_WB;
  const bool joined = joining_ && snapshot->keyframe == sequence_;
  if (joined) carry_over();
  if (snapshot->keyframe == sequence_ && snapshot->adjusted) {
    restart_filter(snapshot->state, snapshot->cov);
  } else if (snapshot->keyframe != sequence_) {
    ++counters_.snapshots_late;
  }
  note_place(snapshot->error, snapshot->state.T_WB.p);
  note_jump(T_WB_before, filter_.state().T_WB, joined);
  view_.assign(*snapshot, filter_.state().T_WB, camera_, cameras_);
  associate(*snapshot, frontends);
}

// The old map's frame from now on, should the adjustment have failed to say so itself.
void Tracker::carry_over() {
  BodyState state = filter_.state();
  move(T_join_, state);
  const Mat15 A = error_transform(T_join_);
  filter_.reset(state, A * filter_.cov() * A.transpose());
  filter_.propagate(last_imu_);
  holding_ = false;
  T_WB_last_frame_ = T_join_ * T_WB_last_frame_;
  joining_ = false;
}

void Tracker::restart_filter(const BodyState& state, const Mat15& cov) {
  const size_t oldest = history_size_ > kHistory ? history_size_ - kHistory : 0;
  size_t i = history_size_;
  while (i > oldest && history_[(i - 1) % kHistory].t >= state.t) --i;
  if (i >= history_size_ || history_[i % kHistory].t != state.t) {
    ++counters_.snapshots_late;
    return;
  }
  filter_.reset(state, cov);
  holding_ = false;
  const SE3 T_WB_last = T_WB_last_frame_;
  for (; i < history_size_; ++i) {
    filter_.propagate(history_[i % kHistory]);
    if (history_[i % kHistory].t == state.t) T_WB_last_frame_ = state.T_WB;
  }
  // Frames since the keyframe were located in the unrefined map: carry them over by the same shift.
  if (last_keyframe_.t == state.t) {
    T_WB_last_frame_ = state.T_WB * last_keyframe_.T_WB.inverse() * T_WB_last;
    last_keyframe_ = state;
  }
}

// Learns which of the living tracks mapping has turned into landmarks or freed from one.
void Tracker::associate(const MapSnapshot& snapshot, Frontend* frontends) {
  struct Entry {
    TrackId id;
    uint16_t index;
  };
  for (int c = 0; c < kCamerasMax; ++c) {
    const Tracks& tracks = frontends[c].tracks();
    FixedVector<Entry, kTracksMax> sorted;
    for (size_t i = 0; i < tracks.size(); ++i) {
      const MapPoint* point = view_.find(landmarks_[c].get(tracks[i]));
      const bool freed =
          point == nullptr || point->epoch != view_.epoch() ||
          (snapshot.keyframe == sequence_ && point->in_newest && point->track[c] != tracks[i].id);
      if (freed) landmarks_[c][tracks[i]] = LandmarkId{};
      (void)sorted.push_back({tracks[i].id, static_cast<uint16_t>(i)});
    }
    const auto less = [](const Entry& a, const Entry& b) { return a.id < b.id; };
    std::sort(sorted.begin(), sorted.end(), less);
    for (const MapPoint& point : snapshot.points) {
      if (point.track[c] == 0) continue;
      const Entry* found =
          std::lower_bound(sorted.begin(), sorted.end(), Entry{point.track[c], 0}, less);
      if (found == sorted.end() || found->id != point.track[c]) continue;
      landmarks_[c][tracks[found->index]] = point.id;
    }
  }
}

void Tracker::match(Frontend* frontends) {
  if (!running_ || view_.empty()) return;
  const PosePrediction pose{filter_.state().T_WB, filter_.cov().topLeftCorner<6, 6>()};
  for (int c = 0; c < cameras_; ++c) {
    counters_.matched_by_projection += static_cast<uint32_t>(match_by_projection(
        view_, pose, camera_[c], params_.matching, frontends[c].tracks(), landmarks_[c]));
  }
}

void Tracker::collect(Frontend* frontends) {
  correspondences_.clear();
  corresponding_.clear();
  const bool at_rest = standstill_.at_rest();
  const double sigma = params_.filter.sigma_px * (at_rest ? params_.filter.standstill_px_scale : 1);
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Track& track : frontends[c].tracks()) {
      const MapPoint* point = view_.find(landmarks_[c].get(track));
      if (point == nullptr || point->epoch != view_.epoch()) continue;
      if (at_rest && !standstill_.stands(c, track)) continue;
      (void)correspondences_.push_back(
          {point->p_W, point->cov, Vec2(track.x, track.y), sigma, c, Gate::kAccepted});
      (void)corresponding_.push_back(&track);  // valid until a track is erased
    }
  }
}

void Tracker::count_misses(Frontend* frontends) {
  for (size_t i = 0; i < correspondences_.size(); ++i) {
    const Gate gate = correspondences_[i].gate;
    counters_.gates.add(gate);
    uint8_t& misses = misses_[correspondences_[i].camera][*corresponding_[i]];
    misses = gate == Gate::kAccepted ? 0 : static_cast<uint8_t>(misses + 1);
  }
  for (int c = 0; c < kCamerasMax; ++c) {
    const Tracks& tracks = frontends[c].tracks();
    for (size_t i = 0; i < tracks.size();) {
      if (static_cast<float>(misses_[c].get(tracks[i])) <= params_.tracker.misses_max) {
        ++i;
        continue;
      }
      frontends[c].erase(i);
      ++counters_.tracks_dropped;
    }
  }
}

void Tracker::judge_standstill(uint8_t present, double dt_s, Frontend* frontends) {
  for (int c = 0; c < cameras_; ++c) {
    if ((present >> c & 1) == 0) continue;
    standstill_.add_tracks(camera_[c], c, frontends[c].tracks(), dt_s);
  }
  StandstillDetector::Expected expected;
  if (running_) {
    const BodyState& state = filter_.state();
    const Vec3 up_B = state.T_WB.R.transpose() * Vec3(0, 0, kGravity_m_s2);
    expected = {true, state.b_g, up_B + state.b_a};
  }
  standstill_.judge(dt_s, expected);
  if (!standstill_.at_rest()) return;
  // Without a descriptor a track becomes no point, and is matched with none.
  for (int c = 0; c < cameras_; ++c) {
    const Tracks& tracks = frontends[c].tracks();
    for (size_t i = 0; i < tracks.size();) {
      if (standstill_.slid(c, tracks[i])) {
        frontends[c].erase(i);
        continue;
      }
      if (standstill_.moves(c, tracks[i])) {
        landmarks_[c][tracks[i]] = LandmarkId{};
        frontends[c].track(i).described = false;
      }
      ++i;
    }
  }
}

// Before what is seen is fused: the filter goes on from the last frame at rest, not from what the
// IMU added since.
void Tracker::stand_still() {
  if (!standstill_.at_rest()) {
    holding_ = false;
    return;
  }
  ++counters_.standstill_frames;
  if (holding_) {
    filter_.hold(rest_state_, rest_cov_, standstill_.last_rate_B(), standstill_.last_force_B());
  } else {
    filter_.update_standstill(standstill_.mean_rate_B());
  }
}

// The cameras that delivered something to see, a bit each.
uint8_t Tracker::seeing(uint8_t present, const Frontend* frontends) const {
  uint8_t out = 0;
  for (int c = 0; c < cameras_; ++c) {
    const bool sees = (present >> c & 1) != 0 && frontends[c].tracks().size() >= kTracksSeeing;
    out |= static_cast<uint8_t>(sees << c);
  }
  return out;
}

FrameResult Tracker::frame(TimeNs t, uint8_t present, Frontend* frontends) {
  FrameResult result;
  ++counters_.frames;
  const double dt_s = last_frame_t_ == 0 ? 0.0 : to_seconds(t - last_frame_t_);
  const uint8_t seen = seeing(present, frontends);
  judge_standstill(present, dt_s, frontends);
  result.at_rest = standstill_.at_rest();
  if (seen == kBoth || last_pair_t_ == 0) last_pair_t_ = t;
  last_frame_t_ = t;
  const bool ran = running_;
  if (ran) {
    update(t, seen, frontends, result);
  } else {
    start(t, seen, frontends, result);
  }
  if (!running_) return result;
  if (ran) maybe_keyframe(t, seen, frontends, result);
  T_WB_last_frame_ = filter_.state().T_WB;
  result.has_pose = true;
  ++counters_.frames_with_pose;
  return result;
}

// The filter's step with what was matched, and what health says of it.
void Tracker::update(TimeNs t, uint8_t seen, Frontend* frontends, FrameResult& result) {
  const SE3 T_WB_predicted = filter_.state().T_WB;
  const int enough = static_cast<int>(params_.health.matches_min);
  stand_still();
  collect(frontends);
  result.correspondences = static_cast<int>(correspondences_.size());
  result.accepted = filter_.update(correspondences_);
  if (result.accepted >= enough) {
    located_ = true;
    light_since_ = 0;
  } else if (seen == 0 || !located_) {
    light_since_ = 0;
  } else {
    if (light_since_ == 0) light_since_ = t;
    relocalize(t, frontends, result);
  }
  count_misses(frontends);
  if (standstill_.at_rest()) {
    holding_ = true;
    rest_state_ = filter_.state();
    rest_cov_ = filter_.cov();
  }
  note_jump(T_WB_predicted, filter_.state().T_WB, result.recognised);
  const double sigma_m = std::sqrt(filter_.cov().diagonal().segment<3>(3).maxCoeff());
  result.health_changed =
      health_.update({t, result.accepted, occupied_cells(), sigma_m, standstill_.at_rest()});
  if (health_.state() == HealthState::kLost) lose();
}

// The map stays: the next start looks for it.
void Tracker::lose() {
  ++counters_.losses;
  running_ = located_ = false;
  origin_ = filter_.state().T_WB;
  origin_t_ = filter_.state().t;
  origin_error_ = map_error_ + error_of_pose(origin_.R, filter_.cov().topLeftCorner<6, 6>());
  starter_.reset();
}

void Tracker::note_jump(const SE3& before, const SE3& after, bool certain) {
  const double turn_rad = so3_log(before.R.transpose() * after.R).norm();
  if (health_.note_jump((after.p - before.p).norm(), turn_rad, certain)) ++counters_.jumps;
}

// Of the image, by the accepted correspondences of the camera that has more.
int Tracker::occupied_cells() const {
  int most = 0;
  for (int c = 0; c < cameras_; ++c) {
    uint32_t cells = 0;
    for (const Correspondence& k : correspondences_) {
      if (k.camera != c || k.gate != Gate::kAccepted) continue;
      const int column = std::clamp(static_cast<int>(4 * k.uv.x() / camera_[c].width), 0, 3);
      const int row = std::clamp(static_cast<int>(3 * k.uv.y() / camera_[c].height), 0, 2);
      cells |= 1u << (4 * row + column);
    }
    int count = 0;
    for (; cells != 0; cells &= cells - 1) ++count;
    most = std::max(most, count);
  }
  return most;
}

void Tracker::interrupt() {
  if (running_) {
    lose();
    health_.lost();
  }
  starter_.reset();
  standstill_.reset();
  holding_ = false;
  has_imu_ = false;
  history_size_ = 0;
  last_frame_t_ = last_pair_t_ = last_recognise_t_ = last_loop_t_ = light_since_ = 0;
  R_BlBn_.setIdentity();
}

// ---- recognising a place ----------------------------------------------------------------------

bool Tracker::recognise(TimeNs t, PlaceRule rule, const Mat3& R_WB, Frontend* frontends,
                        Recognition& out) {
  if (to_seconds(t - last_recognise_t_) < params_.tracker.recognise_every_s) return false;
  last_recognise_t_ = t;
  const Tracks* const tracks[kCamerasMax] = {&frontends[0].tracks(), &frontends[1].tracks()};
  const bool found = recogniser_.solve(view_, rule, R_WB, tracks, out);
  ++(found ? counters_.recognitions : counters_.recognitions_failed);
  return found;
}

// There is light again, but what is seen is not where dead reckoning expects it.
void Tracker::relocalize(TimeNs t, Frontend* frontends, FrameResult& result) {
  Recognition& found = recognition_;
  BodyState state = filter_.state();
  if (!recognise(t, PlaceRule::kSame, state.T_WB.R, frontends, found)) return;
  state.v_WB = found.T_WB.R * state.T_WB.R.transpose() * state.v_WB;
  state.T_WB = found.T_WB;
  Mat15 cov = filter_.cov();
  cov.topRows<6>().setZero();
  cov.leftCols<6>().setZero();
  cov.diagonal().head<3>().setConstant(kRecognised_rad * kRecognised_rad);
  cov.diagonal().segment<3>(3).setConstant(kRecognised_m * kRecognised_m);
  filter_.reset(state, cov);
  filter_.propagate(last_imu_);
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Track& track : frontends[c].tracks()) landmarks_[c][track] = LandmarkId{};
  }
  adopt(found, frontends);
  collect(frontends);
  result.correspondences = static_cast<int>(correspondences_.size());
  result.accepted = filter_.update(correspondences_);
  result.recognised = true;
  light_since_ = 0;
}

void Tracker::adopt(const Recognition& found, Frontend* frontends) {
  for (const Recognition::Match& match : found.matches) {
    landmarks_[match.camera][frontends[match.camera].tracks()[match.track]] = match.landmark;
  }
}

// A start that knew no place looks for the older map; mapping then carries over what it made since.
bool Tracker::try_join(TimeNs t, Frontend* frontends) {
  Recognition& found = recognition_;
  if (!recognise(t, PlaceRule::kOther, filter_.state().T_WB.R, frontends, found)) return false;
  KeyframeMessage* message = begin_keyframe(t, frontends);
  if (message == nullptr) return false;
  T_join_ = found.T_WB * filter_.state().T_WB.inverse();
  message->join = true;
  message->joining = epoch_;
  message->T_join = T_join_;
  move(T_join_, message->state);
  message->epoch = epoch_ = found.epoch;
  message->error = map_error_ + error_of_sigmas(kRecognised_rad, kRecognised_m);
  end_keyframe(*message);
  place_known_ = joining_ = true;
  ++counters_.joins;
  return true;
}

// The pose from what was recognised, left in locator_.
int Tracker::locate(const Recognition& found, const Frontend* frontends) {
  correspondences_.clear();
  for (const Recognition::Match& match : found.matches) {
    const Track& track = frontends[match.camera].tracks()[match.track];
    const MapPoint* point = view_.find(match.landmark);
    if (point == nullptr) continue;
    (void)correspondences_.push_back({point->p_W, point->cov, Vec2(track.x, track.y),
                                      params_.filter.sigma_px, match.camera, Gate::kAccepted});
  }
  return locator_.locate(found.T_WB, {kRecognised_rad, kRecognised_m, 0.2}, correspondences_);
}

// Points now tracked that this keyframe or an earlier one made.
int Tracker::tracked_made_by(uint32_t keyframe, const Frontend* frontends) const {
  int count = 0;
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Track& track : frontends[c].tracks()) {
      const MapPoint* point = view_.find(landmarks_[c].get(track));
      count += point != nullptr && point->first_keyframe <= keyframe ? 1 : 0;
    }
  }
  return count;
}

// A place of this very map is seen again, but not where it should be: the way since was off, and
// mapping spreads that over it.
bool Tracker::try_close(TimeNs t, Frontend* frontends) {
  if (to_seconds(t - last_loop_t_) < params_.tracker.loop_every_s) return false;
  last_loop_t_ = t;
  const SE3& T_WB = filter_.state().T_WB;
  const Tracks* const tracks[kCamerasMax] = {&frontends[0].tracks(), &frontends[1].tracks()};
  Recognition& found = recognition_;
  const int wanted = static_cast<int>(params_.tracker.loop_matches_min);
  if (!recogniser_.solve(view_, PlaceRule::kOld, T_WB.R, tracks, found) ||
      locate(found, frontends) < wanted) {
    return false;
  }
  const SE3& T_found = locator_.state().T_WB;
  Vec6 xi;
  xi << so3_log(T_found.R * T_WB.R.transpose()), T_found.p - T_WB.p;
  const Vec4 off = gauge_of(xi);
  const Mat6 located = error_of_pose(T_found.R, locator_.cov().topLeftCorner<6, 6>()) +
                       error_of_sigmas(kLocated_rad, kLocated_m);
  const Mat4 R = gauge_of(located);
  if (off.dot(R.inverse() * off) < kLoopChi2_max) return false;
  const Mat6 error = error_about(T_WB.p, map_error_at_, map_error_);
  const Mat4 S = params_.tracker.cov_scale * gauge_of(error) + R;
  if (off.dot(S.inverse() * off) > kLoopChi2_max) {
    ++counters_.loops_implausible;
    return false;
  }
  FixedVector<uint32_t, kCamerasMax * kTracksMax> last_seen;
  for (const Recognition::Match& match : found.matches) {
    (void)last_seen.push_back(view_.find(match.landmark)->last_keyframe);
  }
  std::sort(last_seen.begin(), last_seen.end());
  // So many points are tracked that are as old: the pose stands on them already.
  const int held = tracked_made_by(last_seen[last_seen.size() / 2], frontends);
  if (static_cast<float>(held) >
      params_.tracker.loop_held_max * static_cast<float>(last_seen.size())) {
    ++counters_.loops_held;
    return false;
  }
  KeyframeMessage* message = begin_keyframe(t, frontends);
  if (message == nullptr) return false;
  adopt(found, frontends);  // only now: where nothing closes, tracks keep their own points
  observe(frontends, message->observations);
  message->close = true;
  message->off = off;
  message->off_cov = R;
  message->closes_to = last_seen.back();
  xi.head<2>().setZero();
  T_join_ = motion_of(xi, T_WB.p);
  end_keyframe(*message);
  move(T_join_, last_keyframe_);
  joining_ = true;
  ++counters_.loops;
  return true;
}

// ---- starting ---------------------------------------------------------------------------------

// A pair gives depth at once, so one camera alone is looked through only when the other stays away.
Status Tracker::try_start(TimeNs t, uint8_t seen, Frontend* frontends) {
  const bool alone = seen == kLeftAlone || seen == kRightAlone;
  const bool waits =
      cameras_ > 1 && to_seconds(t - last_pair_t_) < params_.tracker.start_mono_after_s;
  if (seen == 0 || (alone && waits)) return Status::kEmpty;
  if (!starter_.idle() && seen != start_cameras_) starter_.reset();
  start_cameras_ = seen;
  const Observations* observations = nullptr;
  if (starter_.wants_keyframe(t)) {
    stereo_pairs_.clear();
    if (!alone) find_stereo(frontends);
    observe(frontends, start_observations_);
    observations = start_observations_;
  }
  if (alone) {
    const int c = seen == kRightAlone ? 1 : 0;
    return starter_.add_mono_frame(t, c, observations, standstill_, origin_);
  }
  return starter_.add_frame(t, frontends[0].tracks(), frontends[1].tracks(), observations,
                            standstill_, origin_);
}

bool Tracker::send_start(const Mat6& error) {
  for (const KeyframeMessage& message : starter_.keyframes()) {
    KeyframeMessage* slot = keyframes_->begin_push();
    if (slot == nullptr) {  // mapping is behind: try again with the next frames
      ++counters_.keyframes_dropped;
      starter_.reset();
      return false;
    }
    *slot = message;
    slot->sequence = ++sequence_;
    slot->epoch = epoch_;
    slot->error = error;
    keyframes_->end_push();
    ++counters_.keyframes;
  }
  return true;
}

// A start continues where the last track ended, unless the map knows better.
Mat6 Tracker::find_place(TimeNs t, Frontend* frontends) {
  Recognition& found = recognition_;
  const BodyState& state = starter_.state();
  last_recognise_t_ = 0;
  place_known_ = view_.points() == 0;
  if (!place_known_ && recognise(t, PlaceRule::kSame, state.T_WB.R, frontends, found)) {
    starter_.move(found.T_WB * state.T_WB.inverse());
    place_known_ = true;
    epoch_ = found.epoch;
    ++counters_.joins;
    return map_error_ + error_of_sigmas(kRecognised_rad, kRecognised_m);
  }
  epoch_ = ++epochs_;
  if (place_known_) return Mat6::Zero();  // the first start defines it
  const double gap_s = to_seconds(t - origin_t_);
  return origin_error_ + error_of_sigmas(kUntracked_rad_s * gap_s, kUntracked_m_s * gap_s);
}

void Tracker::start(TimeNs t, uint8_t seen, Frontend* frontends, FrameResult& result) {
  const Status status = try_start(t, seen, frontends);
  if (status == Status::kStale) ++counters_.start_failures;
  if (status != Status::kOk) return;
  const Mat6 error = find_place(t, frontends);
  if (!send_start(error)) return;
  note_place(error, starter_.state().T_WB.p);
  last_keyframe_ = starter_.state();
  since_keyframe_.reset(last_keyframe_.b_g, last_keyframe_.b_a);
  filter_.reset(last_keyframe_, starter_.cov());
  filter_.propagate(last_imu_);
  running_ = true;
  joining_ = false;
  light_since_ = 0;
  health_.started(t);
  note_jump(origin_, filter_.state().T_WB, true);
  ++counters_.starts;
  result.started = true;
  result.started_at_rest = starter_.at_rest();
  result.health_changed = true;
}

// ---- keyframes --------------------------------------------------------------------------------

void Tracker::maybe_keyframe(TimeNs t, uint8_t seen, Frontend* frontends, FrameResult& result) {
  const bool alone = seen == kLeftAlone || seen == kRightAlone;
  const bool no_depth = alone && view_.own_points() == 0 && standstill_.at_rest();
  const bool waits =
      light_since_ != 0 && to_seconds(t - light_since_) < params_.tracker.recognise_wait_s;
  if (seen == 0 || joining_ || waits || in_doubt_) return;
  if (!(no_depth ? rest_keyframe_due(t)
                 : keyframe_due(t, seen == kRightAlone ? 1 : 0,
                                frontends[seen == kRightAlone ? 1 : 0]))) {
    return;
  }
  stereo_pairs_.clear();
  if (!alone) find_stereo(frontends);
  result.keyframe = true;
  if (!place_known_ && try_join(t, frontends)) {
    result.joined = true;
    return;
  }
  if (try_close(t, frontends)) {
    result.closed = true;
    return;
  }
  KeyframeMessage* message = begin_keyframe(t, frontends);
  if (message == nullptr) return;
  message->restart = message->renew = no_depth;
  end_keyframe(*message);
}

// One camera at rest has no depth: the keyframe that a first move will be measured from is renewed.
bool Tracker::rest_keyframe_due(TimeNs t) const {
  return to_seconds(t - last_keyframe_.t) > params_.tracker.keyframe_interval_s_max;
}

bool Tracker::keyframe_due(TimeNs t, int c, const Frontend& frontend) const {
  const TrackerParams& p = params_.tracker;
  const double dt_s = to_seconds(t - last_keyframe_.t);
  if (dt_s < p.keyframe_interval_s_min || standstill_.at_rest()) return false;
  if (dt_s > p.keyframe_interval_s_max) return true;
  const SE3& T_WB = filter_.state().T_WB;
  if ((T_WB.p - last_keyframe_.T_WB.p).norm() > p.keyframe_distance_m) return true;
  const double cos_turn = 0.5 * ((last_keyframe_.T_WB.R.transpose() * T_WB.R).trace() - 1.0);
  if (cos_turn < cosine(p.keyframe_angle_deg * (3.14159265358979 / 180))) return true;
  size_t matched = 0;
  for (const Track& track : frontend.tracks()) matched += landmarks_[c].get(track).valid() ? 1 : 0;
  return static_cast<float>(matched) <
         p.keyframe_matched_ratio_min * static_cast<float>(frontend.tracks().size());
}

// Gives every left track its counterpart in the right image, and the reverse for tracks of known
// points: near the projection where the point is known, along the epipolar curve where it is not.
void Tracker::find_stereo(Frontend* frontends) {
  stereo_pairs_.clear();
  for (int from = 0; from < kCamerasMax; ++from) {
    const int to = 1 - from;
    const SE3 T_CW_to = (filter_.state().T_WB * camera_[to].T_BC).inverse();
    const size_t count = frontends[from].tracks().size();
    for (size_t i = 0; i < count; ++i) {
      const Track& track = frontends[from].tracks()[i];
      const LandmarkId landmark = landmarks_[from].get(track);
      const MapPoint* point = running_ ? view_.find(landmark) : nullptr;
      const Vec2 uv(track.x, track.y);
      Vec2 uv_to;
      StereoLoss loss;
      if (point != nullptr) {
        bool followed = false;
        for (const Track& other : frontends[to].tracks()) {
          followed |= landmarks_[to].get(other) == landmark;
        }
        Vec2 expected;
        if (followed || !camera_[to].project(T_CW_to * point->p_W, expected) ||
            !camera_[to].in_image(expected, 12)) {
          continue;
        }
        loss = stereo_.find_near(from, frontends[from].pyramid(), frontends[to].pyramid(), uv,
                                 expected, uv_to);
      } else if (from == 0) {
        loss = stereo_.find(from, frontends[from].pyramid(), frontends[to].pyramid(), uv, uv_to);
      } else {
        continue;
      }
      if (loss != StereoLoss::kFound) continue;
      const float x = static_cast<float>(uv_to.x()), y = static_cast<float>(uv_to.y());
      Track* other = frontends[to].nearest(x, y, 2.0f);
      if (other != nullptr && landmarks_[to].get(*other).valid()) continue;  // another point's
      TrackId other_id = other != nullptr ? other->id : 0;
      if (other != nullptr && other->age == 0) {  // a fresh corner gives way to the exact place
        other->x = x;
        other->y = y;
      } else if (other == nullptr) {
        other_id = frontends[to].start_track(x, y, track.described ? &track.descriptor : nullptr);
        if (other_id == 0) continue;
        landmarks_[to][frontends[to].tracks().back()] = landmark;
      }
      if (from == 0) (void)stereo_pairs_.push_back({track.id, other_id});
    }
  }
}

void Tracker::observe(const Frontend* frontends, Observations* observations) const {
  for (int c = 0; c < kCamerasMax; ++c) {
    observations[c].clear();
    for (const Track& track : frontends[c].tracks()) {
      Observation* o = observations[c].append();
      PIRVS_ASSERT(o != nullptr);  // as many as tracks
      *o = Observation{};
      o->landmark = landmarks_[c].get(track);
      o->track = track.id;
      o->x = track.x;
      o->y = track.y;
      o->described = track.described;
      o->descriptor = track.descriptor;
    }
  }
  const auto index_of = [&](int c, TrackId id) {
    for (size_t i = 0; i < observations[c].size(); ++i) {
      if (observations[c][i].track == id) return static_cast<int16_t>(i);
    }
    return int16_t{-1};
  };
  for (const Pair& pair : stereo_pairs_) {
    const int16_t left = index_of(0, pair.left), right = index_of(1, pair.right);
    if (left < 0 || right < 0) continue;
    observations[0][static_cast<size_t>(left)].stereo = right;
    observations[1][static_cast<size_t>(right)].stereo = left;
  }
}

// The next message, filled with what is tracked now, or nullptr: mapping is behind.
KeyframeMessage* Tracker::begin_keyframe(TimeNs t, Frontend* frontends) {
  KeyframeMessage* message = keyframes_->begin_push();
  if (message == nullptr) {
    ++counters_.keyframes_dropped;
    return nullptr;
  }
  message->sequence = ++sequence_;
  message->state = filter_.state();
  message->state.t = t;
  observe(frontends, message->observations);
  message->from_previous = since_keyframe_;
  message->linked = message->adjust = true;
  message->restart = message->renew = message->join = message->close = false;
  message->at_rest = standstill_.at_rest();
  message->epoch = epoch_;
  return message;
}

void Tracker::end_keyframe(const KeyframeMessage& message) {
  last_keyframe_ = message.state;
  keyframes_->end_push();
  ++counters_.keyframes;
  since_keyframe_.reset(filter_.state().b_g, filter_.state().b_a);
}

}  // namespace pirvs
