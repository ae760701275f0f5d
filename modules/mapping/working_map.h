// The map as mapping works on it: its keyframes in order of time, sightings tied to points, and
// what holds of the run since the last start.
// In      keyframes and points from the steps of mapping; rigid motions T of W.
// Out     the map itself, and places in its order: 0 is the oldest keyframe, size() - 1 the newest.
// Frames  W, B. Errors of places: map_error.h.
// Errors  handles of points that have left find nothing. load(): those of load_map().
// Cost    memory only; remove() moves up to kKeyframesMax handles. Mapping's core alone, but while
//         mapping rests.
// Source  PIRVS paper, section IV.C.
#pragma once

#include "modules/map/map.h"
#include "modules/map/map_error.h"
#include "modules/map/map_file.h"
#include "modules/map/messages.h"

namespace pirvs {

// How far the run since the last start may be off: of its first keyframe, of its newest, and what
// the newest adjustment added against the keyframe before.
struct RunErrors {
  Mat6 first = Mat6::Zero(), newest = Mat6::Zero(), added = Mat6::Zero();
};

// Many methods: of keyframes, of the run, of points, a line or a few each.
class WorkingMap {
 public:
  // ---- keyframes ----
  size_t size() const { return order_.size(); }
  bool full() const { return order_.full(); }
  Keyframe& keyframe(size_t place) { return *map_.keyframes.find(order_[place]); }
  const Keyframe& keyframe(size_t place) const { return *map_.keyframes.find(order_[place]); }
  Keyframe& newest() { return keyframe(size() - 1); }
  const Keyframe& newest() const { return keyframe(size() - 1); }
  Keyframe& append(const KeyframeMessage& message);  // not when full(); without its sightings
  void remove(size_t place);
  // Of the oldest keyframe after `sequence`, at or after place `begin`; size(): there is none.
  size_t place_after(uint32_t sequence, size_t begin) const;

  // ---- the run since the last start ----
  void begin_run(const KeyframeMessage& first);
  uint32_t run_sequence() const { return run_sequence_; }  // of its first keyframe
  size_t run_begin() const;                                // place of that keyframe
  // Of a place, if dead reckoning brought the run there since keyframe `sequence`; else 0.
  Mat6 drift_since(uint32_t sequence, const Vec3& at) const;
  RunErrors& errors() { return errors_; }
  const RunErrors& errors() const { return errors_; }

  // ---- points ----
  Pool<Landmark, kLandmarksMax>& points() { return map_.landmarks; }
  static void attach(Observation& sighting, LandmarkId id, Landmark& landmark);
  void detach(Observation& sighting);
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

  // ---- as a whole ----
  const Map& map() const { return map_; }
  Map& map() { return map_; }
  void move(const SE3& T);   // all that is kept
  void level(const SE3& T);  // the same, by a tilt that mapping found out itself
  const SE3& leveled() const { return leveled_; }  // by all such tilts
  SE3 join(const KeyframeMessage& message);  // moves what the run has made to where it belongs
  Status load(const MapSource& source);      // into an empty one; the file ends an earlier run
  void on_removed(void (*sink)(void*, const BodyState&), void* context);

 private:
  Map map_;
  FixedVector<KeyframeId, kKeyframesMax> order_;  // live keyframes, oldest first
  uint32_t run_sequence_ = 0;
  RunErrors errors_;
  struct Drift {
    uint32_t sequence = 0;  // of the first keyframe after it; 0: none that is not made up for
    Vec3 at = Vec3::Zero();
    Mat6 error = Mat6::Zero();
  };
  Drift drift_;
  SE3 leveled_;
  void (*removed_sink_)(void*, const BodyState&) = nullptr;
  void* removed_context_ = nullptr;
};

}  // namespace pirvs
