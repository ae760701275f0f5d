// Recognises a place of the map: a pose from descriptors alone, gravity's direction known.
// In      described tracks of the cameras, the points of a map, an attitude whose tilt is right
//         (its heading need not be).
// Out     T_WB in the points' world, and which track shows which point.
// Frames  W, B, C. What is found turns the given attitude about the vertical.
// Errors  false: too few matches that fit one pose.
// Cost    ~2 ns a pair of track and point: 3 ms for 180 tracks and 8000 points, x86-64, while the
//         place is unknown only; of old points few are in view.
// Source  Fischler, Bolles, 1981 (RANSAC); absolute pose with known vertical direction as in
//         Kukelova et al., ACCV 2010, linear over three points.
#pragma once

#include "modules/matching/projection.h"

namespace pirvs {

// Which points: of the snapshot's epoch; of another; of its epoch, where they should be in view,
// but seen last by a keyframe loop_keyframes_min ago or earlier; of its epoch, wherever, but seen
// last by keyframe `before` or earlier.
enum class PlaceRule : uint8_t { kSame, kOther, kOld, kBefore };

struct Recognition {
  struct Match {
    uint8_t camera;
    uint16_t track;  // place among the camera's tracks
    LandmarkId landmark;
  };
  SE3 T_WB;
  uint16_t epoch = 0;  // of the points
  FixedVector<Match, kCamerasMax * kTracksMax> matches;
};

class Recogniser {
 public:
  void configure(const Camera* cameras, int count, const MatchingParams& params);
  bool solve(const MapView& view, PlaceRule rule, const Mat3& R_WB, const Tracks* const* tracks,
             Recognition& out, uint32_t before = 0);

 private:
  struct Pair {
    uint8_t camera;
    uint16_t track;
    uint16_t point;  // in the view
    Vec3 f_L, c_L;   // ray in the axes of W before the turn that is looked for, origin at B
    Vec3 p_W;
    bool fits;
  };
  struct Guess {
    double cos_turn = 1, sin_turn = 0;
    Vec3 s_L = Vec3::Zero();  // B's place, turned back
  };

  void find_candidates(const MapView& view, PlaceRule rule, uint32_t before);
  void find_pairs(const MapView& view, const Mat3& R_WB, const Tracks* const* tracks);
  static bool fit(const Pair* const* pairs, int count, Guess& out);
  int score(const Guess& guess, bool mark);

  Camera camera_[kCamerasMax];
  int cameras_ = 0;
  MatchingParams params_;
  FixedVector<uint16_t, kLandmarksMax> candidates_;  // points of the view
  FixedVector<Pair, kCamerasMax * kTracksMax> pairs_;
};

}  // namespace pirvs
