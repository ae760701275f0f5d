// Builds and refines the map beside tracking: keyframes in, triangulated and adjusted points out.
// In      KeyframeMessage by ring. Out: MapSnapshot by mailbox; the Map itself, to read at the end.
// Frames  W, B, C as everywhere.
// Errors  none to the caller; what is rejected, and what a full map forgets, is counted by name.
// Cost    step(): ~0.3 ms at most, ~6 ms a keyframe in all, x86-64.
// Source  PIRVS paper, section IV.C.
#pragma once

#include <atomic>

#include "core/base/counter.h"
#include "modules/map/map.h"
#include "modules/map/map_file.h"
#include "modules/map/messages.h"
#include "modules/mapping/bundle.h"
#include "modules/mapping/loop_closure.h"
#include "modules/mapping/mapping_params.h"
#include "modules/matching/triangulate.h"

namespace pirvs {

struct MappingCounters {
  Counter keyframes, keyframes_removed, adjustments, adjustments_failed;
  Counter points_stereo, points_temporal, points_removed, points_full, points_forgotten;
  Counter points_rejected, observations_removed, bundle_full, restarts, joins;
};

inline constexpr CounterRow<MappingCounters> kMappingCounters[] = {
    {"mapping_keyframes", &MappingCounters::keyframes},
    {"keyframes_removed", &MappingCounters::keyframes_removed},
    {"adjustments", &MappingCounters::adjustments},
    {"adjustments_failed", &MappingCounters::adjustments_failed},
    {"points_stereo", &MappingCounters::points_stereo},
    {"points_temporal", &MappingCounters::points_temporal},
    {"points_removed", &MappingCounters::points_removed},
    {"points_full", &MappingCounters::points_full},
    {"points_forgotten", &MappingCounters::points_forgotten},
    {"points_rejected", &MappingCounters::points_rejected},
    {"observations_removed", &MappingCounters::observations_removed},
    {"bundle_full", &MappingCounters::bundle_full},
    {"restarts", &MappingCounters::restarts},
    {"mapping_joins", &MappingCounters::joins},
};
static_assert(every_counter_is_in(kMappingCounters));

// Many methods: the steps of one keyframe into one map; the window and the upkeep share all of it.
class Mapper {
 public:
  explicit Mapper(const MappingCounters& counted = {}) : counters_(counted) {}
  void configure(const Camera* cameras, const ImuNoise& noise, const MappingParams& params,
                 KeyframeRing* keyframes, MapMailbox* snapshots);
  void step();  // one slice of work

  // Any core may ask: is there work, and up to which keyframe is all done?
  bool busy() const { return busy_.load(std::memory_order_acquire) || ring_->size() > 0; }
  uint32_t finished() const { return finished_.load(std::memory_order_acquire); }

  // ---- while it rests ----
  // Everything but what has been counted; configure() and on_keyframe_removed() are next.
  void forget();
  // W is moved by T, a turn about the vertical and a shift: all that is kept, and published.
  void move_world(const SE3& T);
  // The map of an earlier run, into an empty one, published. Errors as load_map().
  Status load(const MapSource& source);
  const Map& map() const { return map_; }
  const MappingCounters& counters() const { return counters_; }
  // Called with each keyframe that leaves the map, refined as it is then.
  void on_keyframe_removed(void (*sink)(void*, const BodyState&), void* context);

 private:
  enum class Phase : uint8_t { kIdle, kBuild, kAdjust, kFinish };

  void insert(const KeyframeMessage& message);
  void join(const KeyframeMessage& message);
  void close(const KeyframeMessage& message);
  size_t run_begin() const;
  void remove_keyframe(size_t order);
  void weigh_keyframes();
  void forget_keyframe();
  void forget_points();
  LandmarkId landmark_of_track(int camera, TrackId track);
  void create_points(Keyframe& keyframe);
  void create_point(Keyframe& keyframe, int camera, size_t index);
  int gather_views(const Keyframe& keyframe, int camera, size_t index, View* views,
                   Observation** sightings);
  void attach(Observation& sighting, LandmarkId id, Landmark& landmark);
  void detach(Observation& sighting);

  void build();
  void choose_fixed(size_t window_begin);
  void hold_error(size_t window_begin);
  void add_points(size_t window_begin);
  void slide_prior(size_t window_begin);
  void finish();
  void write_back();
  void spread_error();
  void remove_outliers();
  void remove_weak_points();
  void publish(bool adjusted);

  Keyframe& keyframe(size_t order) { return *map_.keyframes.find(order_[order]); }
  // Calls visit(camera, sighting, landmark) wherever the point is still in the map: a slot that was
  // released may be another point's by now.
  template <class Visit>
  void for_each_sighting(Keyframe& keyframe, Visit&& visit) {
    for (int c = 0; c < kCamerasMax; ++c) {
      for (Observation& sighting : keyframe.observations[c]) {
        Landmark* landmark = map_.landmarks.find(sighting.landmark);
        if (landmark != nullptr) visit(c, sighting, *landmark);
      }
    }
  }

  static constexpr int kViewsMax = 8;
  static constexpr size_t kWeighedAtOnce = 64;
  Camera camera_[kCamerasMax];
  ImuNoise noise_;
  MappingParams params_;
  KeyframeRing* ring_ = nullptr;
  MapMailbox* mailbox_ = nullptr;
  void (*removed_sink_)(void*, const BodyState&) = nullptr;
  void* removed_context_ = nullptr;

  Map map_;
  FixedVector<KeyframeId, kKeyframesMax> order_;  // live keyframes, oldest first
  size_t weigh_next_ = 0;                         // place in order_
  Phase phase_ = Phase::kIdle;
  std::atomic<bool> busy_{false};
  std::atomic<uint32_t> finished_{0};  // sequence of the newest keyframe that is done with
  Bundle bundle_;
  struct Member {
    uint16_t order;  // place in order_
    int16_t frame;   // in the bundle
  };
  FixedVector<Member, Bundle::kFramesMax> members_;  // keyframes in the bundle, oldest first
  int window_first_ = 0;                             // first free one in members_
  FixedVector<LandmarkId, Bundle::kPointsMax> bundle_points_;
  FixedVector<Observation*, Bundle::kObservationsMax> sightings_;  // as the bundle's observations
  // Working memory of add_points() and close(), too large for a stack.
  struct Grouped {
    Observation* observation;
    int16_t frame, camera;
  };
  FixedVector<Grouped, Bundle::kObservationsMax> sorted_;  // by point
  LoopStep loop_steps_[kKeyframesMax];
  LoopCorrection loop_corrections_[kKeyframesMax];
  SE3 loop_motions_[kKeyframesMax];
  WindowPrior prior_;
  uint32_t run_sequence_ = 0;  // first keyframe of the last start
  Mat15 newest_cov_ = Mat15::Identity();
  Mat6 run_error_ = Mat6::Zero();   // of the last start
  Mat6 held_error_ = Mat6::Zero();  // of what holds the adjustment, about its oldest free frame
  Mat6 newest_error_ = Mat6::Zero(), last_added_ = Mat6::Zero();
  MappingCounters counters_;
};

}  // namespace pirvs
