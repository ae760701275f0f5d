#include "modules/mapping/mapper.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "core/base/assert.h"

namespace pirvs {

void Mapper::configure(const Camera* cameras, const ImuNoise& noise, const MappingParams& params,
                       KeyframeRing* keyframes, MapMailbox* snapshots) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  noise_ = noise;
  params_ = params;
  ring_ = keyframes;
  mailbox_ = snapshots;
}

void Mapper::forget() {
  const MappingCounters counted = counters_;
  this->~Mapper();  // in place: no stack could hold another
  new (this) Mapper(counted);
}

void Mapper::on_keyframe_removed(void (*sink)(void*, const BodyState&), void* context) {
  removed_sink_ = sink;
  removed_context_ = context;
}

void Mapper::step() {
  switch (phase_) {
    case Phase::kIdle: {
      const KeyframeMessage* message = ring_->front();
      if (message == nullptr) return;
      insert(*message);
      const uint32_t sequence = message->sequence;
      const bool adjust = message->adjust;
      if (adjust) {
        busy_.store(true, std::memory_order_release);
        phase_ = Phase::kBuild;
      }
      ring_->pop();  // before it counts as finished: tracking then knows of the room
      if (!adjust) finished_.store(sequence, std::memory_order_release);
      return;
    }
    case Phase::kBuild:
      build();
      phase_ = Phase::kAdjust;
      return;
    case Phase::kAdjust:
      if (bundle_.step()) phase_ = Phase::kFinish;
      return;
    case Phase::kFinish:
      finish();
      phase_ = Phase::kIdle;
      finished_.store(keyframe(order_.size() - 1).sequence, std::memory_order_release);
      busy_.store(false, std::memory_order_release);
      return;
  }
}

// ---- keyframes and points ---------------------------------------------------------------------

// Place in order_ of the last start's first keyframe: an adjustment does not reach beyond it.
size_t Mapper::run_begin() const {
  size_t i = order_.size();
  while (i > 0 && map_.keyframes.find(order_[i - 1])->sequence >= run_sequence_) --i;
  return i;
}

// What the next one knew against this one, it knows against the one before from now on.
void Mapper::remove_keyframe(size_t order) {
  Keyframe& leaving = keyframe(order);
  if (order + 1 < order_.size()) {
    Keyframe& next = keyframe(order + 1);
    next.linked = false;
    next.added += error_about(next.state.T_WB.p, leaving.state.T_WB.p, leaving.added);
  }
  for (Observations& observations : leaving.observations) {
    for (Observation& sighting : observations) detach(sighting);
  }
  if (removed_sink_ != nullptr) removed_sink_(removed_context_, leaving.state);
  (void)map_.keyframes.release(order_[order]);
  for (size_t i = order + 1; i < order_.size(); ++i) order_[i - 1] = order_[i];
  order_.pop_back();
  ++counters_.keyframes_removed;
}

void Mapper::attach(Observation& sighting, LandmarkId id, Landmark& landmark) {
  sighting.landmark = id;
  ++landmark.views;
}

void Mapper::detach(Observation& sighting) {
  Landmark* landmark = map_.landmarks.find(sighting.landmark);
  sighting.landmark = LandmarkId{};
  if (landmark != nullptr) --landmark->views;
}

void Mapper::insert(const KeyframeMessage& message) {
  if (message.restart) {
    if (message.renew) {
      remove_keyframe(order_.size() - 1);
    } else if (!order_.empty()) {
      ++counters_.restarts;
    }
    prior_ = WindowPrior{};
    run_sequence_ = message.sequence;
    run_error_ = newest_error_ = message.error;
  }
  if (message.join) join(message);
  if (order_.size() > kKeyframesMax / 2) weigh_keyframes();
  if (order_.full()) forget_keyframe();
  const Result<KeyframeId> id = map_.keyframes.acquire();
  PIRVS_ASSERT(id.ok());  // order_ holds every live keyframe, and one has just left if it was full
  Keyframe& fresh = *map_.keyframes.find(id.value());
  fresh.sequence = message.sequence;
  fresh.state = message.state;
  fresh.from_previous = message.from_previous;
  fresh.at_rest = message.at_rest;
  fresh.epoch = message.epoch;
  fresh.error = newest_error_;
  fresh.added = last_added_;  // until an adjustment knows better
  fresh.linked = message.linked && !message.restart && !order_.empty() &&
                 keyframe(order_.size() - 1).sequence + 1 == message.sequence;
  const bool added = order_.push_back(id.value());
  PIRVS_ASSERT(added);
  if (message.close) close(message);
  for (int c = 0; c < kCamerasMax; ++c) {
    fresh.observations[c] = message.observations[c];
    for (Observation& sighting : fresh.observations[c]) {
      const LandmarkId landmark_id =
          sighting.landmark.valid() ? sighting.landmark : landmark_of_track(c, sighting.track);
      sighting.landmark = LandmarkId{};
      Landmark* landmark = map_.landmarks.find(landmark_id);
      if (landmark == nullptr || landmark->epoch != fresh.epoch) continue;
      // Two tracks of one camera on one point: the second is a wrong match.
      if (landmark->last_keyframe == fresh.sequence && landmark->track[c] != 0) continue;
      if (landmark->last_keyframe != fresh.sequence) {
        landmark->track[0] = landmark->track[1] = 0;
        landmark->last_keyframe = fresh.sequence;
      }
      landmark->track[c] = sighting.track;
      attach(sighting, landmark_id, *landmark);
    }
  }
  forget_points();
  create_points(fresh);
  ++counters_.keyframes;
}

// The point that a track had in the keyframe before the newest: tracking may not have heard of it
// yet.
LandmarkId Mapper::landmark_of_track(int camera, TrackId track) {
  if (order_.size() < 2 || keyframe(order_.size() - 2).sequence < run_sequence_) {
    return LandmarkId{};
  }
  for (const Observation& sighting : keyframe(order_.size() - 2).observations[camera]) {
    if (sighting.track == track) return sighting.landmark;
  }
  return LandmarkId{};
}

void Mapper::create_points(Keyframe& keyframe) {
  for (int c = 0; c < kCamerasMax; ++c) {
    for (size_t i = 0; i < keyframe.observations[c].size(); ++i) {
      Observation& sighting = keyframe.observations[c][i];
      if (sighting.landmark.valid() || !sighting.described) continue;
      create_point(keyframe, c, i);
    }
  }
}

// All views of one track that has no point yet: here, in the other camera, in the last keyframes.
int Mapper::gather_views(const Keyframe& keyframe, int camera, size_t index, View* views,
                         Observation** sightings) {
  int count = 0;
  const auto add = [&](const Keyframe& from, int c, Observation& sighting) {
    const SE3 T_CW = (from.state.T_WB * camera_[c].T_BC).inverse();
    views[count] = {&camera_[c], T_CW, Vec2(sighting.x, sighting.y)};
    sightings[count++] = &sighting;
  };
  Observation& here = const_cast<Observation&>(keyframe.observations[camera][index]);
  add(keyframe, camera, here);
  if (here.stereo >= 0) {
    Observation& other = const_cast<Observation&>(
        keyframe.observations[1 - camera][static_cast<size_t>(here.stereo)]);
    if (!other.landmark.valid()) add(keyframe, 1 - camera, other);
  }
  const size_t last = order_.size() - 1;
  for (size_t back = 1; back <= last && back <= 6 && count < kViewsMax; ++back) {
    Keyframe& earlier = this->keyframe(last - back);
    if (earlier.sequence < run_sequence_) break;  // what it saw since was never linked to here
    bool seen = false;
    for (Observation& sighting : earlier.observations[camera]) {
      if (sighting.track != here.track || sighting.landmark.valid()) continue;
      add(earlier, camera, sighting);
      seen = true;
      break;
    }
    if (!seen) break;  // a track is never interrupted
  }
  return count;
}

void Mapper::create_point(Keyframe& keyframe, int camera, size_t index) {
  View views[kViewsMax];
  Observation* sightings[kViewsMax];
  const int count = gather_views(keyframe, camera, index, views, sightings);
  if (count < 2) return;
  const bool stereo = count >= 2 && views[0].camera != views[1].camera;
  Triangulated point;
  const float parallax_min = stereo ? params_.stereo_parallax_rad_min : params_.parallax_rad_min;
  if (!triangulate(views, count, params_.sigma_px, point) || point.parallax_rad < parallax_min ||
      point.residual_px_max > params_.new_point_residual_px) {
    ++counters_.points_rejected;
    return;
  }
  const Result<LandmarkId> id = map_.landmarks.acquire();
  if (!id.ok()) {
    ++counters_.points_full;
    return;
  }
  Landmark& landmark = *map_.landmarks.find(id.value());
  landmark = Landmark{};
  landmark.p_W = point.p_W;
  landmark.cov = point.cov;
  landmark.descriptor = keyframe.observations[camera][index].descriptor;
  const Vec3 towards = (keyframe.state.T_WB * camera_[camera].T_BC).p - point.p_W;
  landmark.distance_m = static_cast<float>(towards.norm());
  landmark.view_W = towards / towards.norm();
  landmark.first_keyframe = landmark.last_keyframe = keyframe.sequence;
  landmark.epoch = keyframe.epoch;
  landmark.track[camera] = keyframe.observations[camera][index].track;
  if (stereo) landmark.track[1 - camera] = sightings[1]->track;
  for (int i = 0; i < count; ++i) attach(*sightings[i], id.value(), landmark);
  ++(stereo ? counters_.points_stereo : counters_.points_temporal);
}

// ---- adjustment -------------------------------------------------------------------------------

void Mapper::build() {
  bundle_.begin(camera_, noise_, params_);
  members_.clear();
  const size_t window = std::min(order_.size() - run_begin(), static_cast<size_t>(params_.window));
  const size_t window_begin = order_.size() - window;
  slide_prior(window_begin);
  choose_fixed(window_begin);
  hold_error(window_begin);
  window_first_ = static_cast<int>(members_.size());
  for (size_t i = window_begin; i < order_.size(); ++i) {
    const Keyframe& member = keyframe(i);
    const int frame = bundle_.add_frame(member.state, false);
    PIRVS_ASSERT(frame >= 0);  // window <= Bundle::kFreeMax by its range
    (void)members_.push_back({static_cast<uint16_t>(i), static_cast<int16_t>(frame)});
    if (i == window_begin) {
      bundle_.set_prior(frame, prior_);
    } else if (member.linked) {
      bundle_.link(frame - 1, frame, member.from_previous);
    }
  }
  add_points(window_begin);
}

// Takes the prior along to the oldest keyframe of the window.
void Mapper::slide_prior(size_t window_begin) {
  const size_t begin = run_begin();
  if (prior_.sequence == 0) {
    const Keyframe& first = keyframe(begin);
    prior_ = start_prior(first.sequence, first.state, params_, first.at_rest);
  }
  for (size_t i = begin + 1; i <= window_begin; ++i) {
    const Keyframe &a = keyframe(i - 1), &b = keyframe(i);
    if (a.sequence < prior_.sequence) continue;
    prior_ = advance(prior_, a.state, b.sequence, b.state, b.linked ? &b.from_previous : nullptr,
                     noise_, params_);
  }
}

// Older keyframes that share the most points with the window.
void Mapper::choose_fixed(size_t window_begin) {
  if (window_begin == 0) return;
  uint64_t in_window[kLandmarksMax / 64] = {};
  for (size_t i = window_begin; i < order_.size(); ++i) {
    for_each_sighting(keyframe(i), [&](int, const Observation& sighting, const Landmark&) {
      in_window[sighting.landmark.slot / 64] |= uint64_t{1} << (sighting.landmark.slot % 64);
    });
  }
  struct Candidate {
    uint16_t order;
    int shared;
  };
  FixedVector<Candidate, kKeyframesMax> candidates;
  for (size_t i = 0; i < window_begin; ++i) {
    int by_camera[kCamerasMax] = {};
    for_each_sighting(keyframe(i), [&](int c, const Observation& sighting, const Landmark&) {
      const uint16_t slot = sighting.landmark.slot;
      by_camera[c] += in_window[slot / 64] >> (slot % 64) & 1 ? 1 : 0;
    });
    // By the camera that shares more: one of them may not have delivered.
    const int shared = *std::max_element(std::begin(by_camera), std::end(by_camera));
    if (static_cast<float>(shared) >= params_.shared_points_min) {
      (void)candidates.push_back({static_cast<uint16_t>(i), shared});
    }
  }
  const size_t wanted = static_cast<size_t>(params_.fixed_keyframes);
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.shared != b.shared ? a.shared > b.shared : a.order > b.order;
  });
  if (candidates.size() > wanted) candidates.resize(wanted);
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.order < b.order; });
  for (const Candidate& candidate : candidates) {
    const int frame = bundle_.add_frame(keyframe(candidate.order).state, true);
    if (frame < 0) break;
    (void)members_.push_back({candidate.order, static_cast<int16_t>(frame)});
  }
}

// The error that the fixed keyframes share: of many, the mean, since theirs are much the same.
// Without any, the prior's anchor holds, which was set at the keyframe before the window.
void Mapper::hold_error(size_t window_begin) {
  const Vec3& at = keyframe(window_begin).state.T_WB.p;
  if (window_begin == run_begin()) {
    held_error_ = run_error_;
    return;
  }
  held_error_.setZero();
  const auto add = [&](const Keyframe& k, double weight) {
    held_error_ += weight * error_about(at, k.state.T_WB.p, k.error);
  };
  for (const Member& fixed : members_) add(keyframe(fixed.order), 1.0 / double(members_.size()));
  if (members_.empty()) add(keyframe(window_begin - 1), 1.0);
}

// Observations are grouped by point for the bundle: a counting sort over the landmarks' slots.
void Mapper::add_points(size_t window_begin) {
  bundle_points_.clear();
  sightings_.clear();
  static constexpr uint16_t kNone = UINT16_MAX;
  uint16_t place[kLandmarksMax];
  std::fill(std::begin(place), std::end(place), kNone);
  uint16_t counts[Bundle::kPointsMax] = {};
  for (size_t i = order_.size(); i-- > window_begin;) {  // newest first: they matter most
    for_each_sighting(keyframe(i), [&](int, const Observation& sighting, const Landmark&) {
      uint16_t& at = place[sighting.landmark.slot];
      if (at != kNone) return;
      if (!bundle_points_.push_back(sighting.landmark)) {
        ++counters_.bundle_full;
        return;
      }
      at = static_cast<uint16_t>(bundle_points_.size() - 1);
    });
  }
  const auto for_each = [&](auto&& visit) {
    for (const Member& member : members_) {
      for_each_sighting(keyframe(member.order), [&](int c, Observation& sighting, const Landmark&) {
        const uint16_t at = place[sighting.landmark.slot];
        if (at != kNone) visit(at, Grouped{&sighting, member.frame, int16_t(c)});
      });
    }
  };
  size_t total = 0;
  for_each([&](uint16_t point, const Grouped&) {
    if (total >= Bundle::kObservationsMax) return;
    ++counts[point];
    ++total;
  });
  uint32_t next[Bundle::kPointsMax];
  uint32_t sum = 0;
  for (size_t p = 0; p < bundle_points_.size(); ++p) {
    next[p] = sum;
    sum += counts[p];
  }
  sorted_.resize(total);
  size_t visited = 0;
  for_each([&](uint16_t point, const Grouped& entry) {
    if (visited++ < total) sorted_[next[point]++] = entry;
  });
  size_t at = 0;
  for (size_t p = 0; p < bundle_points_.size(); ++p) {
    const int point = bundle_.add_point(map_.landmarks.find(bundle_points_[p])->p_W);
    for (uint16_t k = 0; k < counts[p]; ++k, ++at) {
      const Grouped& entry = sorted_[at];
      const bool added =
          bundle_.add_observation(point, entry.frame, entry.camera,
                                  Vec2(entry.observation->x, entry.observation->y)) &&
          sightings_.push_back(entry.observation);
      PIRVS_ASSERT(added);  // total was limited above
    }
  }
}

void Mapper::finish() {
  const bool adjusted = bundle_.solved() && bundle_.errors_known();
  ++counters_.adjustments;
  if (adjusted) {
    write_back();
    spread_error();
  } else {
    ++counters_.adjustments_failed;
  }
  remove_outliers();  // above all after a failure: the next adjustment would meet them again
  remove_weak_points();
  publish(adjusted);
}

void Mapper::write_back() {
  for (size_t m = static_cast<size_t>(window_first_); m < members_.size(); ++m) {
    keyframe(members_[m].order).state = bundle_.state(members_[m].frame);
  }
  for (size_t p = 0; p < bundle_points_.size(); ++p) {
    Landmark* landmark = map_.landmarks.find(bundle_points_[p]);
    landmark->p_W = bundle_.point(static_cast<int>(p));
    landmark->cov = bundle_.point_cov(static_cast<int>(p));
  }
}

// What holds the adjustment is off itself: so is all that it holds, and more so the less firmly.
// The points near the newest keyframe are as far off as it is, whatever tracking makes of them.
void Mapper::spread_error() {
  Keyframe& oldest = keyframe(members_[static_cast<size_t>(window_first_)].order);
  const Keyframe& newest = keyframe(order_.size() - 1);
  const Mat6& A = bundle_.oldest_follows();
  newest_cov_ = bundle_.newest_cov();
  last_added_ = oldest.added = error_of_pose(oldest.state.T_WB.R, bundle_.oldest_pose_cov());
  oldest.error = error_of_pose(oldest.state.T_WB.R, A * held_error_ * A.transpose()) + oldest.added;
  const Mat6 B = bundle_.newest_follows().topRows<6>();
  newest_error_ = error_of_pose(
      newest.state.T_WB.R, B * held_error_ * B.transpose() + newest_cov_.topLeftCorner<6, 6>());
}

void Mapper::remove_outliers() {
  size_t at = 0;
  const Keyframe& newest = keyframe(order_.size() - 1);
  for (int p = 0; p < bundle_.points(); ++p) {
    for (int k = 0; k < bundle_.observations(p); ++k, ++at) {
      if (bundle_.residual_sigma(p, k) < params_.outlier_sigma) continue;
      Observation& sighting = *sightings_[at];
      Landmark* landmark = map_.landmarks.find(sighting.landmark);
      if (landmark != nullptr && landmark->last_keyframe == newest.sequence) {
        for (TrackId& track : landmark->track) {
          if (track == sighting.track) track = 0;  // tracking must not go on with it
        }
      }
      detach(sighting);
      ++counters_.observations_removed;
    }
  }
}

// A point needs two views, and once its first keyframes are past, three.
void Mapper::remove_weak_points() {
  const uint32_t newest = keyframe(order_.size() - 1).sequence;
  for (size_t slot = 0; slot < map_.landmarks.capacity(); ++slot) {
    const Landmark* landmark = map_.landmarks.at(slot);
    if (landmark == nullptr) continue;
    const uint16_t wanted = newest - landmark->last_keyframe > 2 ? 3 : 2;
    if (landmark->views >= wanted) continue;
    (void)map_.landmarks.release(map_.landmarks.handle(slot));
    ++counters_.points_removed;
  }
}

}  // namespace pirvs
