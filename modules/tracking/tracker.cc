#include "modules/tracking/tracker.h"

#include <algorithm>
#include <cmath>

#include "core/base/assert.h"
#include "core/math/so3.h"
#include "core/math/trig.h"

namespace pirvs {

void Tracker::configure(const Camera* cameras, const ImuNoise& noise, const TrackingParams& params,
                        KeyframeRing* keyframes, MapMailbox* map) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  noise_ = noise;
  params_ = params;
  keyframes_ = keyframes;
  mailbox_ = map;
  filter_.configure(cameras, noise, params.filter);
  starter_.configure(cameras, noise, params.filter, params.tracker);
  stereo_.configure(cameras[0], cameras[1], params.stereo);
  health_.configure(params.health);
  standstill_.configure(params.health);
  view_.clear();
}

void Tracker::add_imu(const ImuSample& sample) {
  standstill_.add_imu(sample);
  history_[history_size_++ % kHistory] = sample;
  if (running_) {
    filter_.propagate(sample);
    if (has_imu_) {
      since_keyframe_.add(last_imu_.w_B, last_imu_.f_B, sample.w_B, sample.f_B,
                          to_seconds(sample.t - last_imu_.t), noise_);
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

Vec3 Tracker::prepare(Frontend* frontends) {
  if (!running_) {
    for (int c = 0; c < kCamerasMax; ++c) {
      const Mat3 R_BC = camera_[c].T_BC.R;
      frontends[c].predict(R_BC.transpose() * R_BlBn_.transpose() * R_BC);
    }
    R_BlBn_.setIdentity();
    return -last_imu_.f_B;
  }
  take_snapshot(frontends);
  const SE3& T_WB = filter_.state().T_WB;
  for (int c = 0; c < kCamerasMax; ++c) {
    const SE3 T_CW = (T_WB * camera_[c].T_BC).inverse();
    const SE3 T_CW_last = (T_WB_last_frame_ * camera_[c].T_BC).inverse();
    frontends[c].predict(T_CW.R * T_CW_last.R.transpose());
    for (Track& track : frontends[c].tracks()) {
      const MapPoint* point = view_.find(track.landmark);
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
  if (snapshot->keyframe == sequence_) {
    restart_filter(snapshot->state, snapshot->cov);
  } else {
    ++counters_.snapshots_late;
  }
  view_.assign(*snapshot, filter_.state().T_WB, camera_, kCamerasMax);
  associate(*snapshot, frontends);
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
  const SE3 T_WB_before = T_WB_last_frame_;
  for (; i < history_size_; ++i) {
    filter_.propagate(history_[i % kHistory]);
    if (history_[i % kHistory].t == state.t) T_WB_last_frame_ = state.T_WB;
  }
  // Frames since the keyframe were located in the unrefined map: carry them over by the same shift.
  if (last_keyframe_.t == state.t) {
    T_WB_last_frame_ = state.T_WB * last_keyframe_.T_WB.inverse() * T_WB_before;
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
    Tracks& tracks = frontends[c].tracks();
    FixedVector<Entry, kTracksMax> sorted;
    for (size_t i = 0; i < tracks.size(); ++i) {
      const MapPoint* point = view_.find(tracks[i].landmark);
      const bool freed = point == nullptr || (snapshot.keyframe == sequence_ && point->in_newest &&
                                              point->track[c] != tracks[i].id);
      if (freed) tracks[i].landmark = LandmarkId{};
      (void)sorted.push_back({tracks[i].id, static_cast<uint16_t>(i)});
    }
    const auto less = [](const Entry& a, const Entry& b) { return a.id < b.id; };
    std::sort(sorted.begin(), sorted.end(), less);
    for (const MapPoint& point : snapshot.points) {
      if (point.track[c] == 0) continue;
      const Entry* found =
          std::lower_bound(sorted.begin(), sorted.end(), Entry{point.track[c], 0}, less);
      if (found == sorted.end() || found->id != point.track[c]) continue;
      tracks[found->index].landmark = point.id;
    }
  }
}

void Tracker::match(Frontend* frontends) {
  if (!running_ || view_.empty()) return;
  const PosePrediction pose{filter_.state().T_WB, filter_.cov().topLeftCorner<6, 6>()};
  for (int c = 0; c < kCamerasMax; ++c) {
    counters_.matched_by_projection += static_cast<uint32_t>(
        match_by_projection(view_, pose, camera_[c], params_.tracker, frontends[c].tracks()));
  }
}

void Tracker::collect(Frontend* frontends) {
  correspondences_.clear();
  corresponding_.clear();
  for (int c = 0; c < kCamerasMax; ++c) {
    for (Track& track : frontends[c].tracks()) {
      const MapPoint* point = view_.find(track.landmark);
      if (point == nullptr) continue;
      const double sigma = params_.filter.sigma_px;
      (void)correspondences_.push_back(
          {point->p_W, point->cov, Vec2(track.x, track.y), sigma, c, Gate::kAccepted});
      (void)corresponding_.push_back(&track);  // valid until a track is erased
    }
  }
}

void Tracker::count_misses(Frontend* frontends) {
  for (size_t i = 0; i < correspondences_.size(); ++i) {
    const Gate gate = correspondences_[i].gate;
    ++counters_.gates[static_cast<int>(gate)];
    Track& track = *corresponding_[i];
    track.misses = gate == Gate::kAccepted ? 0 : static_cast<uint8_t>(track.misses + 1);
  }
  for (int c = 0; c < kCamerasMax; ++c) {
    Tracks& tracks = frontends[c].tracks();
    for (size_t i = 0; i < tracks.size();) {
      if (static_cast<float>(tracks[i].misses) <= params_.tracker.misses_max) {
        ++i;
        continue;
      }
      tracks.erase_unordered(i);
      ++counters_.tracks_dropped;
    }
  }
}

double Tracker::image_motion(const Frontend& frontend) const {
  FixedVector<float, kTracksMax> moved;
  for (const Track& track : frontend.tracks()) {
    if (track.age == 0) continue;
    const float dx = track.x - track.x_last, dy = track.y - track.y_last;
    (void)moved.push_back(std::sqrt(dx * dx + dy * dy));
  }
  if (moved.size() < 5) return 1e9;
  std::nth_element(moved.begin(), moved.begin() + moved.size() / 2, moved.end());
  return moved[moved.size() / 2];
}

FrameResult Tracker::frame(TimeNs t, bool stereo, Frontend* frontends) {
  FrameResult result;
  ++counters_.frames;
  const double dt_s = last_frame_t_ == 0 ? 0.0 : to_seconds(t - last_frame_t_);
  standstill_.add_image_motion(image_motion(frontends[0]), dt_s);
  last_frame_t_ = t;
  if (!running_) {
    if (stereo) start(t, frontends, result);
    if (!running_) return result;
  } else {
    collect(frontends);
    result.correspondences = static_cast<int>(correspondences_.size());
    result.accepted = filter_.update(correspondences_);
    count_misses(frontends);
    if (standstill_.at_rest()) {
      filter_.update_standstill(standstill_.mean_rate_B());
      ++counters_.standstill_frames;
    }
    const double sigma_m = std::sqrt(filter_.cov().diagonal().segment<3>(3).maxCoeff());
    result.health_changed = health_.update(t, result.accepted, sigma_m);
    if (health_.state() == HealthState::kLost) {
      lose();
      return result;
    }
    if (stereo && keyframe_due(t, frontends)) {
      find_stereo(frontends);
      send_keyframe(t, frontends);
      result.keyframe = true;
    }
  }
  T_WB_last_frame_ = filter_.state().T_WB;
  result.has_pose = true;
  ++counters_.frames_with_pose;
  return result;
}

void Tracker::lose() {
  ++counters_.losses;
  running_ = false;
  origin_ = filter_.state().T_WB;
  starter_.reset();
  view_.clear();
}

void Tracker::interrupt() {
  if (running_) {
    lose();
    health_.lost();
  }
  starter_.reset();
  standstill_.reset();
  has_imu_ = false;
  history_size_ = 0;
  last_frame_t_ = 0;
  R_BlBn_.setIdentity();
}

void Tracker::start(TimeNs t, Frontend* frontends, FrameResult& result) {
  const Observations* observations = nullptr;
  if (starter_.wants_keyframe(t)) {
    find_stereo(frontends);
    observe(frontends, start_observations_);
    observations = start_observations_;
  }
  const Status status = starter_.add_frame(t, frontends[0].tracks(), frontends[1].tracks(),
                                           observations, standstill_, origin_);
  if (status == Status::kStale) ++counters_.start_failures;
  if (status != Status::kOk) return;
  for (const KeyframeMessage& message : starter_.keyframes()) {
    KeyframeMessage* slot = keyframes_->begin_push();
    if (slot == nullptr) {  // mapping is behind: try again with the next frames
      ++counters_.keyframes_dropped;
      starter_.reset();
      return;
    }
    *slot = message;
    slot->sequence = ++sequence_;
    keyframes_->end_push();
    ++counters_.keyframes;
  }
  last_keyframe_ = starter_.state();
  since_keyframe_.reset(last_keyframe_.b_g, last_keyframe_.b_a);
  filter_.reset(last_keyframe_, starter_.cov());
  filter_.propagate(last_imu_);
  running_ = true;
  health_.started(t);
  ++counters_.starts;
  result.started = true;
  result.started_at_rest = starter_.at_rest();
  result.health_changed = true;
}

bool Tracker::keyframe_due(TimeNs t, const Frontend* frontends) const {
  const TrackerParams& p = params_.tracker;
  const double dt_s = to_seconds(t - last_keyframe_.t);
  if (dt_s < p.keyframe_interval_s_min || standstill_.at_rest()) return false;
  if (dt_s > p.keyframe_interval_s_max) return true;
  const SE3& T_WB = filter_.state().T_WB;
  if ((T_WB.p - last_keyframe_.T_WB.p).norm() > p.keyframe_distance_m) return true;
  const double cos_turn = 0.5 * ((last_keyframe_.T_WB.R.transpose() * T_WB.R).trace() - 1.0);
  if (cos_turn < cosine(p.keyframe_angle_deg * (3.14159265358979 / 180))) return true;
  size_t matched = 0;
  for (const Track& track : frontends[0].tracks()) matched += track.landmark.valid() ? 1 : 0;
  return static_cast<float>(matched) <
         p.keyframe_matched_ratio_min * static_cast<float>(frontends[0].tracks().size());
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
      Track& track = frontends[from].tracks()[i];
      const MapPoint* point = running_ ? view_.find(track.landmark) : nullptr;
      const Vec2 uv(track.x, track.y);
      Vec2 uv_to;
      StereoLoss loss;
      if (point != nullptr) {
        bool followed = false;
        for (const Track& other : frontends[to].tracks()) {
          followed |= other.landmark == track.landmark;
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
      if (other != nullptr && other->landmark.valid()) continue;  // another point's
      TrackId other_id = other != nullptr ? other->id : 0;
      if (other != nullptr && other->age == 0) {  // a fresh corner gives way to the exact place
        other->x = x;
        other->y = y;
      } else if (other == nullptr) {
        other_id = frontends[to].start_track(x, y, track.described ? &track.descriptor : nullptr);
        if (other_id == 0) continue;
        frontends[to].tracks().back().landmark = track.landmark;
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
      o->landmark = track.landmark;
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

void Tracker::send_keyframe(TimeNs t, Frontend* frontends) {
  KeyframeMessage* message = keyframes_->begin_push();
  if (message == nullptr) {
    ++counters_.keyframes_dropped;
    return;
  }
  message->sequence = ++sequence_;
  message->state = filter_.state();
  message->state.t = t;
  observe(frontends, message->observations);
  message->from_previous = since_keyframe_;
  message->linked = true;
  message->adjust = true;
  message->restart = false;
  keyframes_->end_push();
  ++counters_.keyframes;
  last_keyframe_ = filter_.state();
  last_keyframe_.t = t;
  since_keyframe_.reset(filter_.state().b_g, filter_.state().b_a);
}

}  // namespace pirvs
