#include "modules/mapping/adjustment.h"

#include <algorithm>

#include <Eigen/LU>

#include "core/base/assert.h"

namespace pirvs {
namespace {

constexpr double kTiltBest_rad = 1e-4;  // nobody knows a tilt better

}  // namespace

void Adjustment::configure(const Camera* cameras, const ImuNoise& noise,
                           const MappingParams& params, MappingCounters* counters) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  noise_ = noise;
  params_ = params;
  counters_ = counters;
}

void Adjustment::build(WorkingMap& map) {
  bundle_.begin(camera_, noise_, params_);
  members_.clear();
  const size_t window = std::min(map.size() - map.run_begin(), static_cast<size_t>(params_.window));
  const size_t window_begin = map.size() - window;
  slide_prior(map, window_begin);
  choose_fixed(map, window_begin);
  hold_error(map, window_begin);
  window_first_ = static_cast<int>(members_.size());
  for (size_t i = window_begin; i < map.size(); ++i) {
    const Keyframe& member = map.keyframe(i);
    const int frame = bundle_.add_frame(member.state, false);
    PIRVS_ASSERT(frame >= 0);  // window <= Bundle::kFreeMax by its range
    (void)members_.push_back({static_cast<uint16_t>(i), static_cast<int16_t>(frame)});
    if (i == window_begin) {
      bundle_.set_prior(frame, prior_);
    } else if (member.linked) {
      bundle_.link(frame - 1, frame, member.from_previous, member.way_from_previous);
    }
  }
  if (window_first_ > 0) {
    Mat2 known = held_error_.topLeftCorner<2, 2>();
    known.diagonal().array() += kTiltBest_rad * kTiltBest_rad;
    bundle_.free_tilt(known.inverse());
  }
  add_points(map, window_begin);
}

// Takes the prior along to the oldest keyframe of the window.
void Adjustment::slide_prior(WorkingMap& map, size_t window_begin) {
  const size_t begin = map.run_begin();
  if (prior_.sequence == 0) {
    const Keyframe& first = map.keyframe(begin);
    prior_ = start_prior(first.sequence, first.state, params_, first.at_rest);
  }
  for (size_t i = begin + 1; i <= window_begin; ++i) {
    const Keyframe &a = map.keyframe(i - 1), &b = map.keyframe(i);
    if (a.sequence < prior_.sequence) continue;
    const Mat6 vision =
        vision_of_ == a.sequence ? params_.prior_vision_weight * vision_ : guessed_vision();
    const Motions motions{&b.from_previous, &b.way_from_previous};
    prior_ = advance(prior_, a.state, b.sequence, b.state, b.linked ? &motions : nullptr, vision,
                     noise_, params_);
  }
}

// Older keyframes that share the most points with the window.
void Adjustment::choose_fixed(WorkingMap& map, size_t window_begin) {
  if (window_begin == 0) return;
  uint64_t in_window[kLandmarksMax / 64] = {};
  for (size_t i = window_begin; i < map.size(); ++i) {
    map.for_each_sighting(map.keyframe(i), [&](int, const Observation& sighting, const Landmark&) {
      in_window[sighting.landmark.slot / 64] |= uint64_t{1} << (sighting.landmark.slot % 64);
    });
  }
  struct Candidate {
    uint16_t place;
    int shared;
  };
  FixedVector<Candidate, kKeyframesMax> candidates;
  for (size_t i = 0; i < window_begin; ++i) {
    int by_camera[kCamerasMax] = {};
    map.for_each_sighting(map.keyframe(i),
                          [&](int c, const Observation& sighting, const Landmark&) {
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
    return a.shared != b.shared ? a.shared > b.shared : a.place > b.place;
  });
  if (candidates.size() > wanted) candidates.resize(wanted);
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.place < b.place; });
  for (const Candidate& candidate : candidates) {
    const int frame = bundle_.add_frame(map.keyframe(candidate.place).state, true);
    if (frame < 0) break;
    (void)members_.push_back({candidate.place, static_cast<int16_t>(frame)});
  }
}

// The error that the fixed keyframes share: of many, the mean, since theirs are much the same.
// Without any, the prior's anchor holds, which was set at the keyframe before the window.
void Adjustment::hold_error(WorkingMap& map, size_t window_begin) {
  const Vec3& at = map.keyframe(window_begin).state.T_WB.p;
  held_drift_.setZero();
  if (window_begin == map.run_begin()) {
    held_error_ = map.errors().first;
    return;
  }
  held_error_.setZero();
  const auto add = [&](const Keyframe& k, double weight) {
    held_error_ += weight * error_about(at, k.state.T_WB.p, k.error);
  };
  for (const Member& fixed : members_)
    add(map.keyframe(fixed.place), 1.0 / double(members_.size()));
  if (!members_.empty()) return;
  const Keyframe& before = map.keyframe(window_begin - 1);
  add(before, 1.0);
  if (map.drift_since(map.keyframe(window_begin).sequence, at).isZero(0)) {
    held_drift_ = map.drift_since(before.sequence, at);  // it lies between the two
    held_error_ += held_drift_;
  }
}

// Observations are grouped by point for the bundle: a counting sort over the landmarks' slots.
void Adjustment::add_points(WorkingMap& map, size_t window_begin) {
  points_.clear();
  sightings_.clear();
  static constexpr uint16_t kNone = UINT16_MAX;
  uint16_t in_bundle[kLandmarksMax];
  std::fill(std::begin(in_bundle), std::end(in_bundle), kNone);
  uint16_t counts[Bundle::kPointsMax] = {};
  for (size_t i = map.size(); i-- > window_begin;) {  // newest first: they matter most
    map.for_each_sighting(map.keyframe(i), [&](int, const Observation& sighting, const Landmark&) {
      uint16_t& at = in_bundle[sighting.landmark.slot];
      if (at != kNone) return;
      if (!points_.push_back(sighting.landmark)) {
        ++counters_->bundle_full;
        return;
      }
      at = static_cast<uint16_t>(points_.size() - 1);
    });
  }
  const auto for_each = [&](auto&& visit) {
    for (const Member& member : members_) {
      map.for_each_sighting(map.keyframe(member.place),
                            [&](int c, Observation& sighting, const Landmark&) {
                              const uint16_t at = in_bundle[sighting.landmark.slot];
                              if (at != kNone)
                                visit(at, Grouped{&sighting, member.frame, int16_t(c)});
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
  for (size_t p = 0; p < points_.size(); ++p) {
    next[p] = sum;
    sum += counts[p];
  }
  sorted_.resize(total);
  size_t visited = 0;
  for_each([&](uint16_t point, const Grouped& entry) {
    if (visited++ < total) sorted_[next[point]++] = entry;
  });
  size_t at = 0;
  for (size_t p = 0; p < points_.size(); ++p) {
    const int point = bundle_.add_point(map.points().find(points_[p])->p_W);
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

bool Adjustment::finish(WorkingMap& map) {
  const bool adjusted = bundle_.solved() && bundle_.errors_known();
  ++counters_->adjustments;
  if (adjusted) {
    write_back(map);
    spread_error(map);
  } else if (bundle_.points() > 0) {  // one camera's first keyframe has none: nothing to adjust
    ++counters_->adjustments_failed;
  }
  remove_outliers(map);  // above all after a failure: the next adjustment would meet them again
  return adjusted;
}

// The whole map stands as upright as the window has found out: it turns about its oldest place, so
// that what was close to a start stays where it was told to be. Returns how far the place has moved
// about which the adjustment had tilted its frames.
Vec3 Adjustment::level(WorkingMap& map) {
  if (!bundle_.tilt_free()) return Vec3::Zero();
  const Vec3 pivot = bundle_.tilted_at(), oldest = map.keyframe(0).state.T_WB.p;
  SE3 T;
  T.R = bundle_.tilted();
  T.p = oldest - T.R * oldest;
  map.level(T);
  const Vec3 shift = T * pivot - pivot;
  prior_.mean.T_WB.p += shift;  // its attitude is what gravity said: it stays
  held_error_.topRows<2>().setZero();
  held_error_.leftCols<2>().setZero();
  held_error_.topLeftCorner<2, 2>() = bundle_.tilt_cov();
  return shift;
}

void Adjustment::write_back(WorkingMap& map) {
  const Vec3 shift = level(map);
  for (size_t m = static_cast<size_t>(window_first_); m < members_.size(); ++m) {
    Keyframe& member = map.keyframe(members_[m].place);
    member.state = bundle_.state(members_[m].frame);
    member.state.T_WB.p += shift;
  }
  for (size_t p = 0; p < points_.size(); ++p) {
    Landmark* landmark = map.points().find(points_[p]);
    if (landmark->kept) continue;
    landmark->p_W = bundle_.point(static_cast<int>(p)) + shift;
    landmark->cov = bundle_.point_cov(static_cast<int>(p));
  }
  vision_ = bundle_.oldest_vision();
  vision_of_ = map.keyframe(members_[static_cast<size_t>(window_first_)].place).sequence;
}

// The fixed keyframes have pose errors of their own. Their covariance is propagated to the oldest
// free keyframe and to the newest one: shift and heading in full, of the tilt what levelling has
// left; and what dead reckoning may have added within the window, which the IMU links alone would
// promise too little of. The points near the newest keyframe are taken to have its error.
void Adjustment::spread_error(WorkingMap& map) {
  Keyframe& oldest = map.keyframe(members_[static_cast<size_t>(window_first_)].place);
  const Keyframe& newest = map.newest();
  const Mat6& A = bundle_.oldest_follows();
  newest_cov_ = bundle_.newest_cov();
  map.errors().added = oldest.added = error_of_pose(oldest.state.T_WB.R, bundle_.oldest_pose_cov());
  oldest.error = error_of_pose(oldest.state.T_WB.R, A * held_error_ * A.transpose()) + oldest.added;
  oldest.added += held_drift_;  // against the keyframe before; `held_error_` has it already
  const Mat6 B = bundle_.newest_follows().topRows<6>();
  map.errors().newest = error_of_pose(
      newest.state.T_WB.R, B * held_error_ * B.transpose() + newest_cov_.topLeftCorner<6, 6>());
  map.errors().newest += map.drift_since(oldest.sequence, newest.state.T_WB.p);
}

void Adjustment::remove_outliers(WorkingMap& map) {
  size_t at = 0;
  const Keyframe& newest = map.newest();
  for (int p = 0; p < bundle_.points(); ++p) {
    for (int k = 0; k < bundle_.observations(p); ++k, ++at) {
      if (bundle_.residual_sigma(p, k) < params_.outlier_sigma) continue;
      Observation& sighting = *sightings_[at];
      Landmark* landmark = map.points().find(sighting.landmark);
      if (landmark != nullptr && landmark->last_keyframe == newest.sequence) {
        for (TrackId& track : landmark->track) {
          if (track == sighting.track) track = 0;  // tracking must not go on with it
        }
      }
      map.detach(sighting);
      ++counters_->observations_removed;
    }
  }
}

}  // namespace pirvs
