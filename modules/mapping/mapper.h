// Builds and refines the map beside tracking: keyframes in, triangulated and adjusted points out.
// In      KeyframeMessage by ring. Out: MapSnapshot by mailbox; the Map itself, to read at the end.
// Frames  W, B, C as everywhere.
// Errors  none to the caller; what is rejected, and what a full map forgets, is counted by name.
// Cost    step(): 0.13 ms in the median, 0.6 ms at p99; ~6 ms a keyframe in all; x86-64.
// Source  PIRVS paper, section IV.C.
#pragma once

#include <atomic>

#include "modules/mapping/adjustment.h"
#include "modules/mapping/loop_closure.h"
#include "modules/mapping/mapping_counters.h"
#include "modules/mapping/mapping_params.h"
#include "modules/mapping/working_map.h"

namespace pirvs {

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
  const Map& map() const { return map_.map(); }
  Map& map() { return map_.map(); }  // its nodes
  const MappingCounters& counters() const { return counters_; }
  // Called with each keyframe that leaves the map, refined as it is then.
  void on_keyframe_removed(void (*sink)(void*, const BodyState&), void* context);

 private:
  enum class Phase : uint8_t { kIdle, kBuild, kAdjust, kFinish };

  void insert(const KeyframeMessage& message);
  void make_room();
  void remove_keyframe(size_t place);
  void tie_sightings(const KeyframeMessage& message, Keyframe& fresh);
  LandmarkId landmark_of_track(int camera, TrackId track) const;
  void publish(bool adjusted);
  size_t window() const { return static_cast<size_t>(params_.window); }

  Camera camera_[kCamerasMax];
  MappingParams params_;
  KeyframeRing* ring_ = nullptr;
  MapMailbox* mailbox_ = nullptr;

  WorkingMap map_;
  Adjustment adjustment_;
  LoopCloser loop_closer_;
  size_t weigh_next_ = 0;  // place in the map's order
  Phase phase_ = Phase::kIdle;
  std::atomic<bool> busy_{false};
  std::atomic<uint32_t> finished_{0};  // sequence of the newest keyframe that is done with
  MappingCounters counters_;
};

}  // namespace pirvs
