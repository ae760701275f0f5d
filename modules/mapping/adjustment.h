// One bundle adjustment after the other: over the newest keyframes of the map and the points they
// see, held by a prior on the oldest of them and by older, covisible keyframes that stay fixed but
// for a tilt of the whole map, which levels it.
// In      the map, its newest keyframe just inserted.
// Out     finish(): refined states and points in the map, sightings that proved wrong cut off, and
//         how far the newest keyframe may be off.
// Frames  W, B; error order theta (in B, right), p, v (in W), b_g, b_a.
// Errors  counted: adjustments_failed, no step lowered the cost (nothing is written back);
//         bundle_full, points left out; observations_removed, outliers.
// Cost    A slice of mapper.h each: build(), step(), finish(). Mapping's core alone.
// Source  PIRVS paper, section IV.C; ORB-SLAM's local bundle adjustment for the fixed keyframes;
//         docs/adr/0007-error-of-the-map.md and 0015-the-map-is-leveled-as-one.md.
#pragma once

#include "modules/mapping/bundle.h"
#include "modules/mapping/mapping_counters.h"
#include "modules/mapping/window_prior.h"
#include "modules/mapping/working_map.h"

namespace pirvs {

class Adjustment {
 public:
  void configure(const Camera* cameras, const ImuNoise& noise, const MappingParams& params,
                 MappingCounters* counters);

  void build(WorkingMap& map);
  bool step() { return bundle_.step(); }  // true: all is done
  bool finish(WorkingMap& map);           // true: the map was adjusted

  // ---- between two adjustments ----
  void forget_prior() { prior_ = WindowPrior{}; }
  WindowPrior& prior() { return prior_; }
  // Of the newest keyframe's state against the map, as the last one that succeeded left it.
  const Mat15& newest_cov() const { return newest_cov_; }

 private:
  void slide_prior(WorkingMap& map, size_t window_begin);
  void choose_fixed(WorkingMap& map, size_t window_begin);
  void hold_error(WorkingMap& map, size_t window_begin);
  void add_points(WorkingMap& map, size_t window_begin);
  Vec3 level(WorkingMap& map);
  void write_back(WorkingMap& map);
  void spread_error(WorkingMap& map);
  void remove_outliers(WorkingMap& map);

  Camera camera_[kCamerasMax];
  ImuNoise noise_;
  MappingParams params_;
  MappingCounters* counters_ = nullptr;

  WindowPrior prior_;
  Mat6 held_error_ = Mat6::Zero();  // of what holds the adjustment, about its oldest free frame
  Mat6 held_drift_ = Mat6::Zero();  // the part of it that dead reckoning just before that frame is
  Mat6 vision_ = Mat6::Zero();  // vision's information about the pose of the oldest free keyframe
  uint32_t vision_of_ = 0;      // that keyframe
  Mat15 newest_cov_ = Mat15::Identity();

  Bundle bundle_;
  struct Member {
    uint16_t place;  // in the map's order
    int16_t frame;   // in the bundle
  };
  FixedVector<Member, Bundle::kFramesMax> members_;  // keyframes in the bundle, oldest first
  int window_first_ = 0;                             // first free one in members_
  FixedVector<LandmarkId, Bundle::kPointsMax> points_;
  FixedVector<Observation*, Bundle::kObservationsMax> sightings_;  // as the bundle's observations
  // Working memory of add_points(), too large for a stack.
  struct Grouped {
    Observation* observation;
    int16_t frame, camera;
  };
  FixedVector<Grouped, Bundle::kObservationsMax> sorted_;  // by point
};

}  // namespace pirvs
