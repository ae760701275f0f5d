// What tracking and mapping tell each other: keyframes by ring, the refined map by mailbox. Neither
// includes the other.
// Frames  W, B, C as in map.h.
// Errors  none: what finds no room the sender counts.
// Cost    memory: a message ~60 kB, a snapshot ~1.6 MB; the mailbox holds three.
// Source  PIRVS paper, section IV: tracking and mapping run in parallel.
#pragma once

#include "core/store/mailbox.h"
#include "core/store/ring.h"
#include "modules/map/map.h"

namespace pirvs {

// What tracking needs of a landmark, copied out of the map so that both sides can run at once.
struct MapPoint {
  LandmarkId id;
  Vec3 p_W;
  Mat3 cov;
  Descriptor descriptor;
  Vec3 view_W;
  float distance_m;
  TrackId track[kCamerasMax];
  bool in_newest;           // the newest keyframe saw it: `track` is complete
  uint32_t first_keyframe;  // that made it
  uint32_t last_keyframe;   // the newest that saw it
  uint16_t epoch;
};

// Mapping's word to tracking after each adjustment, by mailbox.
struct MapSnapshot {
  uint32_t keyframe = 0;      // sequence of the newest adjusted keyframe
  uint16_t epoch = 0;         // of that keyframe
  bool adjusted = false;      // the adjustment succeeded: state and cov hold
  BodyState state;            // of that keyframe, refined
  SE3 leveled;                // of the map, by all tilts that mapping has corrected so far
  Mat15 cov = Mat15::Zero();  // of that state against the map: theta, p, v, b_g, b_a
  Mat6 error = Mat6::Zero();  // of the map there: map_error.h, about the place of that state
  FixedVector<MapPoint, kLandmarksMax> points;
};

// Tracking's word to mapping, by ring: a new keyframe as it was tracked.
struct KeyframeMessage {
  uint32_t sequence = 0;
  BodyState state;
  SE3 leveled;  // the map that tracking knew (MapSnapshot): its frame is that of `state`
  Observations observations[kCamerasMax];
  Preintegration from_previous;
  WheelPath way_from_previous;
  bool linked = false;
  bool adjust = true;  // false: more keyframes follow at once (start-up)
  uint16_t epoch = 0;
  bool restart = false;       // a start: nothing links it to the keyframe before
  Mat6 error = Mat6::Zero();  // of a start: how uncertain its place is, map_error.h
  bool renew = false;         // in place of the keyframe before
  // The place was recognised: what `joining` made moves by `T_join` and belongs to `epoch` from
  // now.
  bool join = false;
  uint16_t joining = 0;
  SE3 T_join;  // a turn about the vertical and a shift
  // An old place was recognised: keyframes after `closes_to` are off, this one by a turn about the
  // vertical and a shift, of covariance off_cov (loop_closure.h). Some observations name old
  // points.
  bool close = false;
  uint32_t closes_to = 0;
  Vec4 off = Vec4::Zero();
  Mat4 off_cov = Mat4::Identity();
  bool at_rest = false;  // the body stands still: its velocity is known to be zero
  // Not 0: nothing was followed since the keyframe before, and the place is not recognised: how far
  // dead reckoning may be off, map_error.h.
  Mat6 drift = Mat6::Zero();
};

inline constexpr size_t kStartKeyframesMax = 14;  // of one start
// Keyframes that may wait for mapping.
inline constexpr size_t kKeyframeRing = kStartKeyframesMax  // a whole start
                                        + 1                 // being adjusted
                                        + 2;                // slack
using KeyframeRing = Ring<KeyframeMessage, kKeyframeRing>;
using MapMailbox = Mailbox<MapSnapshot>;

}  // namespace pirvs
