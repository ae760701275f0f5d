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
#include "modules/state/body_state.h"
#include "modules/wheels/wheel_path.h"

namespace pirvs {

inline constexpr size_t kKeyframesMax = 384;
inline constexpr size_t kLandmarksMax = 8192;
inline constexpr size_t kNodesMax = 32, kNodeName = 24;  // a name with its zero

struct Keyframe;
using KeyframeId = Handle<Keyframe>;
struct Landmark;
using LandmarkId = Handle<Landmark>;

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
  bool kept = false;                    // of a loaded map that stays as it is
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
  WheelPath way_from_previous;   // the same, by the wheels
  bool linked = false;           // from_previous holds
  bool at_rest = false;
  bool kept = false;          // of a loaded map that stays as it is
  float worth = 1e9f;         // what would be missed without it; new ones are not weighed yet
  uint16_t epoch = 0;         // one for each start: only within one are places exact to each other
  Mat6 error = Mat6::Zero();  // of the pose: map_error.h, about its own place
  Mat6 added = Mat6::Zero();  // of that, against the keyframe before
};

// A named place (nodes.h).
struct Node {
  char name[kNodeName] = "";
  KeyframeId keyframe;  // to which it is fixed
  SE3 T_KN;
};

struct Map {
  Pool<Landmark, kLandmarksMax> landmarks;
  Pool<Keyframe, kKeyframesMax> keyframes;
  FixedVector<Node, kNodesMax> nodes;
};

// ---- what a rigid motion T of W does ----------------------------------------------------------

inline void move(const SE3& T, Landmark& point) {
  point.p_W = T * point.p_W;
  point.cov = (T.R * point.cov * T.R.transpose()).eval();
  point.view_W = T.R * point.view_W;
}

}  // namespace pirvs
