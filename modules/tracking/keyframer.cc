#include "modules/tracking/keyframer.h"

#include "core/base/assert.h"
#include "core/math/trig.h"

namespace pirvs {

void Keyframer::configure(const Camera* cameras, const ImuNoise& noise, const TrackerParams& params,
                          const StereoParams& stereo, KeyframeRing* ring) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  noise_ = noise;
  params_ = params;
  ring_ = ring;
  stereo_.configure(cameras[0], cameras[1], stereo);
}

void Keyframer::integrate(const ImuSample& before, const ImuSample& now) {
  const Mat3 dR_before = since_last_.dR;
  const double dt_s = to_seconds(now.t - before.t);
  since_last_.add(before.w_B, before.f_B, now.w_B, now.f_B, dt_s,
                  bridged(noise_, static_cast<double>(now.gap_s)));
  way_.turn(dR_before, since_last_, dt_s);
}

void Keyframer::begin_motion(const Vec3& b_g, const Vec3& b_a) {
  since_last_.reset(b_g, b_a);
  way_.begin();
}

bool Keyframer::rest_due(TimeNs t) const {
  return to_seconds(t - last_.t) > params_.keyframe_interval_s_max;
}

bool Keyframer::due(TimeNs t, const SE3& T_WB, int c, const Associator& seen) const {
  const double dt_s = to_seconds(t - last_.t);
  if (dt_s < params_.keyframe_interval_s_min) return false;
  if (dt_s > params_.keyframe_interval_s_max) return true;
  if ((T_WB.p - last_.T_WB.p).norm() > params_.keyframe_distance_m) return true;
  const double cos_turn = 0.5 * ((last_.T_WB.R.transpose() * T_WB.R).trace() - 1.0);
  if (cos_turn < cosine(params_.keyframe_angle_deg * (3.14159265358979 / 180))) return true;
  size_t matched = 0;
  for (const Track& track : seen.tracks(c)) matched += seen.landmark(c, track).valid() ? 1 : 0;
  return static_cast<float>(matched) <
         params_.keyframe_matched_ratio_min * static_cast<float>(seen.tracks(c).size());
}

// ---- stereo pairs -----------------------------------------------------------------------------

void Keyframer::find_pairs(const SE3* T_WB, Associator& seen) {
  pairs_.clear();
  for (int from = 0; from < kCamerasMax; ++from) {
    SE3 T_CW_to;
    if (T_WB != nullptr) T_CW_to = (*T_WB * camera_[1 - from].T_BC).inverse();
    const size_t count = seen.tracks(from).size();
    for (size_t i = 0; i < count; ++i) pair(from, i, T_WB != nullptr ? &T_CW_to : nullptr, seen);
  }
  constexpr size_t kFew = 10;  // one in so many
  if (kFew * pairs_.size() < seen.tracks(0).size()) {
    stereo_.compare_looks(seen.tracks(0), seen.tracks(1));
  }
}

void Keyframer::pair(int from, size_t index, const SE3* T_CW_to, Associator& seen) {
  const Track& track = seen.tracks(from)[index];
  Vec2 uv_to;
  if (!find_counterpart(from, track, T_CW_to, seen, uv_to)) return;
  const TrackId other = place_counterpart(1 - from, uv_to, track, seen.landmark(from, track), seen);
  if (other != 0 && from == 0) (void)pairs_.push_back({track.id, other});
}

// Where the other camera sees the track's point. From the right one only known points are looked
// for, and only those that no track follows there.
bool Keyframer::find_counterpart(int from, const Track& track, const SE3* T_CW_to, Associator& seen,
                                 Vec2& uv_to) {
  const int to = 1 - from;
  const LandmarkId landmark = seen.landmark(from, track);
  const MapPoint* point = T_CW_to != nullptr ? seen.map().find(landmark) : nullptr;
  const PyramidStore &image_from = seen.frontend(from).pyramid(),
                     &image_to = seen.frontend(to).pyramid();
  const Vec2 uv(track.x, track.y);
  if (point == nullptr) {
    return from == 0 && stereo_.find(from, image_from, image_to, uv, uv_to) == StereoLoss::kFound;
  }
  for (const Track& other : seen.tracks(to)) {
    if (seen.landmark(to, other) == landmark) return false;
  }
  Vec2 expected;
  if (!camera_[to].project(*T_CW_to * point->p_W, expected) ||
      !camera_[to].in_image(expected, 12)) {
    return false;
  }
  return stereo_.find_near(from, image_from, image_to, uv, expected, uv_to) == StereoLoss::kFound;
}

// The track of camera `to` at that place, if need be a new one; 0: there can be none.
TrackId Keyframer::place_counterpart(int to, const Vec2& uv_to, const Track& track,
                                     LandmarkId landmark, Associator& seen) const {
  const float x = static_cast<float>(uv_to.x()), y = static_cast<float>(uv_to.y());
  Track* other = seen.frontend(to).nearest(x, y, 2.0f);
  if (other == nullptr) {
    const Descriptor* const descriptor = track.described ? &track.descriptor : nullptr;
    const TrackId fresh = seen.frontend(to).start_track(x, y, descriptor);
    if (fresh != 0) seen.set_landmark(to, seen.tracks(to).back(), landmark);
    return fresh;
  }
  if (seen.landmark(to, *other).valid()) return 0;  // another point's
  if (other->age == 0) {                            // a fresh corner gives way to the exact place
    other->x = x;
    other->y = y;
  }
  return other->id;
}

// ---- messages ---------------------------------------------------------------------------------

void Keyframer::observe(const Associator& seen, Observations* observations) const {
  for (int c = 0; c < kCamerasMax; ++c) {
    observations[c].clear();
    for (const Track& track : seen.tracks(c)) {
      Observation* o = observations[c].append();
      PIRVS_ASSERT(o != nullptr);  // as many as tracks
      *o = Observation{};
      o->landmark = seen.landmark(c, track);
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
  for (const StereoPair& pair : pairs_) {
    const int16_t left = index_of(0, pair.left), right = index_of(1, pair.right);
    if (left < 0 || right < 0) continue;
    observations[0][static_cast<size_t>(left)].stereo = right;
    observations[1][static_cast<size_t>(right)].stereo = left;
  }
}

KeyframeMessage* Keyframer::begin(const BodyState& state, bool at_rest, uint16_t epoch,
                                  const Associator& seen) {
  if (!has_room(1)) {
    ++dropped_;
    return nullptr;
  }
  KeyframeMessage* const message = ring_->begin_push();
  PIRVS_ASSERT(message != nullptr);  // what mapping has done is no longer in the ring
  message->sequence = ++sequence_;
  message->state = state;
  message->leveled = seen.map().leveled();
  observe(seen, message->observations);
  message->from_previous = since_last_;
  way_.end();
  message->way_from_previous = way_;
  message->linked = message->adjust = true;
  message->restart = message->renew = message->join = message->close = false;
  message->drift.setZero();
  message->at_rest = at_rest;
  message->epoch = epoch;
  return message;
}

// `state`: the filter's, which the next motion is integrated with.
void Keyframer::end(const KeyframeMessage& message, const BodyState& state) {
  last_ = message.state;
  ring_->end_push();
  begin_motion(state.b_g, state.b_a);
}

bool Keyframer::send_start(const StartKeyframes& keyframes, uint16_t epoch, const Mat6& error,
                           const Associator& seen) {
  if (!has_room(keyframes.size())) {
    dropped_ += static_cast<uint32_t>(keyframes.size());
    return false;
  }
  for (const KeyframeMessage& message : keyframes) {
    KeyframeMessage* const slot = ring_->begin_push();
    PIRVS_ASSERT(slot != nullptr);
    *slot = message;
    slot->sequence = ++sequence_;
    slot->leveled = seen.map().leveled();
    slot->epoch = epoch;
    slot->error = error;
    ring_->end_push();
  }
  last_ = keyframes.back().state;
  begin_motion(last_.b_g, last_.b_a);
  return true;
}

void Keyframer::refine(const BodyState& state) {
  if (last_.t == state.t) last_ = state;
}

}  // namespace pirvs
