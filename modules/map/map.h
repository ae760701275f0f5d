// The sparse map: landmarks seen by keyframes, in fixed pools; mapping owns and changes it.
// Frames  W: world, z up. B: body. C: camera. Pixels: distorted, (0,0) = centre of the first pixel.
// Units   m, m/s, rad, px, ns. Landmark::cov in m^2, in W.
// Errors  handles of released objects find nothing; full pools are counted by mapping.
// Cost    memory only: see kKeyframesMax and kLandmarksMax.
// Source  PIRVS paper, section IV.C.
#pragma once

#include "core/base/time.h"
#include "core/kernels/describe/describe.h"
#include "core/math/se3.h"
#include "core/store/fixed_vector.h"
#include "core/store/pool.h"
#include "modules/frontend/frontend.h"
#include "modules/imu/preintegration.h"

namespace pirvs {

inline constexpr size_t kKeyframesMax = 384;
inline constexpr size_t kLandmarksMax = 8192;

struct Keyframe;
using KeyframeId = Handle<Keyframe>;

struct Landmark {
  Vec3 p_W = Vec3::Zero();
  Mat3 cov = Mat3::Zero();
  Descriptor descriptor{};
  Vec3 view_W = Vec3::Zero();           // unit vector from the point to where it was first seen
  float distance_m = 0;                 // from there
  uint16_t views = 0;                   // observations in the map's keyframes, both cameras
  uint32_t first_keyframe = 0;          // sequence number of the keyframe that made it
  uint32_t last_keyframe = 0;           // of the newest that saw it
  TrackId track[kCamerasMax] = {0, 0};  // its tracks in that keyframe
  uint16_t epoch = 0;                   // of the keyframe that made it
};

// The state of the body at one instant.
struct BodyState {
  TimeNs t = 0;
  SE3 T_WB;
  Vec3 v_WB = Vec3::Zero();
  Vec3 b_g = Vec3::Zero(), b_a = Vec3::Zero();
};

struct Observation {
  LandmarkId landmark;  // invalid: not (yet) triangulated
  TrackId track = 0;
  float x = 0, y = 0;
  bool described = false;
  int16_t stereo = -1;  // index in the other camera's list, same scene point
  Descriptor descriptor{};
};
using Observations = FixedVector<Observation, kTracksMax>;

struct Keyframe {
  uint32_t sequence = 0;  // 1, 2, 3 ... in order of time
  BodyState state;
  Observations observations[kCamerasMax];
  Preintegration from_previous;  // motion since keyframe `sequence - 1`
  bool linked = false;           // from_previous holds
  bool at_rest = false;
  float worth = 1e9f;         // what would be missed without it; new ones are not weighed yet
  uint16_t epoch = 0;         // one for each start: only within one are places exact to each other
  Mat6 error = Mat6::Zero();  // of the pose: map_error.h, about its own place
  Mat6 added = Mat6::Zero();  // of that, against the keyframe before
};

struct Map {
  Pool<Landmark, kLandmarksMax> landmarks;
  Pool<Keyframe, kKeyframesMax> keyframes;
};

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
  Mat15 cov = Mat15::Zero();  // of that state against the map: theta, p, v, b_g, b_a
  Mat6 error = Mat6::Zero();  // of the map there: map_error.h, about the place of that state
  FixedVector<MapPoint, kLandmarksMax> points;
};

// Tracking's word to mapping, by ring: a new keyframe as it was tracked.
struct KeyframeMessage {
  uint32_t sequence = 0;
  BodyState state;
  Observations observations[kCamerasMax];
  Preintegration from_previous;
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
};

// ---- what a rigid motion T of W does ----------------------------------------------------------

inline void move(const SE3& T, BodyState& state) {
  state.T_WB = T * state.T_WB;
  state.v_WB = T.R * state.v_WB;
}

inline void move(const SE3& T, Landmark& point) {
  point.p_W = T * point.p_W;
  point.cov = (T.R * point.cov * T.R.transpose()).eval();
  point.view_W = T.R * point.view_W;
}

// To a state's error: place and velocity are told in W, the attitude's error in B.
inline Mat15 turn_of_error(const SE3& T) {
  Mat15 A = Mat15::Identity();
  A.block<3, 3>(3, 3) = A.block<3, 3>(6, 6) = T.R;
  return A;
}

}  // namespace pirvs
