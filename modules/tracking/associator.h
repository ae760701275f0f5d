// Data association: which landmark of the map each track shows, in all cameras.
// In      the front-ends between two images; map snapshots; the predicted pose; what was
//         recognised.
// Out     correspondences for the filter; where each track is expected next; landmarks of tracks.
// Errors  none: a track that shows nothing known gives no correspondence.
// Cost    ~0.1 ms a frame, x86-64.
// Source  PIRVS paper, section IV.A.
#pragma once

#include "modules/frontend/frontend.h"
#include "modules/matching/projection.h"
#include "modules/matching/recognise.h"
#include "modules/standstill/standstill.h"
#include "modules/tracking/filter.h"
#include "modules/tracking/recent_frames.h"
#include "modules/tracking/turn_check.h"

namespace pirvs {

// A landmark as a viewer wants it.
struct SeenPoint {
  LandmarkId id;
  Vec3 p_W = Vec3::Zero();
  double sigma_m = 0;  // root of the mean variance of its axes
};

// What tracking makes of a track, for a viewer.
enum class TrackUse : uint8_t {
  kNew,       // it shows no point yet
  kWaiting,   // its point is not in the map at hand
  kUsed,      // its point agrees with the pose
  kRejected,  // its point disagreed with the pose in the last image
  kCount
};

// Many methods: what tracks and landmarks are asked together, a few lines each.
class Associator {
 public:
  // `cameras` and `frontends`: kCamerasMax of them, of which the first `count` exist. The
  // front-ends stay the caller's, and nobody else changes their tracks between two images.
  void configure(const Camera* cameras, int count, const MatchingParams& params,
                 Frontend* frontends);

  const MapView& map() const { return map_; }
  Frontend& frontend(int c) { return frontends_[c]; }
  const Tracks& tracks(int c) const { return frontends_[c].tracks(); }
  LandmarkId landmark(int c, const Track& track) const { return landmarks_[c].get(track); }
  void set_landmark(int c, const Track& track, LandmarkId id) { landmarks_[c][track] = id; }
  // The point that the track shows, where the newest snapshot has it, or nullptr.
  const MapPoint* point(int c, const Track& track) const { return map_.find(landmark(c, track)); }

  TrackUse use(int c, const Track& track) const;

  // Takes a new map and learns which living tracks it has turned into landmarks or freed from one.
  // `newest`: sequence of the newest keyframe that was sent.
  void take(const MapSnapshot& snapshot, const SE3& T_WB, uint32_t newest);
  // Tells every track where to look after the body has turned by R_BlBn, or moved from one pose to
  // the other.
  void predict(const Mat3& R_BlBn);
  void predict(const SE3& T_WB_last, const SE3& T_WB);
  // Gives landmarks in view to tracks that have none. Returns how many.
  int match(const PosePrediction& pose);
  // Gives tracks the landmarks that were recognised.
  void adopt(const Recognition& found);
  void forget_landmarks();

  // Adds each camera's tracks to the votes on standstill.
  void vote(uint8_t present, double dt_s, StandstillDetector& standstill) const;
  // Tells `check` how far the tracks of a camera say that the body has turned, against the gyro.
  void compare(uint8_t present, const Vec3& turn_B, double dt_s, TurnCheck& check) const;
  // At rest: drops tracks that slid, and takes from those that move what they showed.
  void drop_movers(const StandstillDetector& standstill);

  // Of all tracks whose landmark is exact to the pose; at rest of those that stand. They hold until
  // a track is erased.
  Correspondences& collect(double sigma_px, const StandstillDetector& standstill);
  // The same of a frame of the past, by the places that its tracks had.
  Correspondences& collect(double sigma_px, const RecentFrames& frames, uint32_t frame);
  // Of the last collect(), after the filter gated them: image cells with an accepted one, in the
  // camera that has more.
  int known_tracks() const;         // that show a point of the map
  int lasting_tracks(int c) const;  // that are more than noise
  int lasting_tracks() const;       // of the camera with more of them
  int occupied_cells() const;
  // Drops tracks that were gated out more than misses_max times in a row. Returns how many.
  int drop_misfits(float misses_max);

  // The cameras that delivered something to see, a bit each.
  uint8_t seeing(uint8_t present) const;
  // Landmarks that tracks show, each once. Returns the count.
  int seen_points(SeenPoint* out, int max) const;
  // Points now tracked that this keyframe or an earlier one made.
  int tracked_made_by(uint32_t keyframe) const;

 private:
  void begin_collecting();
  void add(int c, const Track& track, const Vec2& uv, double sigma_px);

  Camera camera_[kCamerasMax];
  int cameras_ = kCamerasMax;
  MatchingParams params_;
  Frontend* frontends_ = nullptr;
  MapView map_;
  LandmarkTable landmarks_[kCamerasMax];
  TrackTable<uint8_t> misses_[kCamerasMax];  // images in a row that gated the landmark out
  Correspondences correspondences_;
  FixedVector<const Track*, kCamerasMax * kTracksMax> corresponding_;  // their tracks
};

}  // namespace pirvs
