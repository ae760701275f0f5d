// Finds map points again that no track follows: projects them with the predicted pose and takes the
// nearest descriptor among the unmatched tracks inside a window that follows from the covariance.
// In      a MapView, the predicted pose with its 6 x 6 covariance (theta in B, p in W), one camera
//         with its tracks, and the landmarks that they show already.
// Out     the landmarks of newly matched tracks, in the same table.
// Frames  W, B, C as everywhere.
// Errors  none; what was looked at and matched is counted.
// Cost    ~60 ns a candidate point, x86-64.
// Source  PIRVS paper, section IV.A, last paragraphs.
#pragma once

#include "core/camera/camera.h"
#include "modules/frontend/track_table.h"
#include "modules/map/messages.h"
#include "modules/matching/matching_params.h"

namespace pirvs {

// A MapSnapshot with an index, and the short list of points of its epoch that may be in view.
class MapView {
 public:
  void assign(const MapSnapshot& snapshot, const SE3& T_WB, const Camera* cameras, int count);
  void clear();
  const MapPoint* find(LandmarkId id) const;
  const FixedVector<uint16_t, kLandmarksMax>& local() const { return local_; }
  uint32_t keyframe() const { return snapshot_ == nullptr ? 0 : snapshot_->keyframe; }
  const SE3& leveled() const { return leveled_; }  // the newest map that was seen
  uint16_t epoch() const { return snapshot_ == nullptr ? 0 : snapshot_->epoch; }
  const MapPoint& point(uint16_t index) const { return snapshot_->points[index]; }
  bool empty() const { return snapshot_ == nullptr; }
  size_t points() const { return snapshot_ == nullptr ? 0 : snapshot_->points.size(); }
  size_t own_points() const { return own_points_; }  // of the epoch

 private:
  const MapSnapshot* snapshot_ = nullptr;
  SE3 leveled_;
  uint16_t index_[kLandmarksMax];  // slot -> place in snapshot_->points
  FixedVector<uint16_t, kLandmarksMax> local_;
  size_t own_points_ = 0;
};

struct PosePrediction {
  SE3 T_WB;
  Mat6 cov = Mat6::Zero();
};

// The landmark that each track of one camera shows. Not valid: none that is known.
using LandmarkTable = TrackTable<LandmarkId>;

// Returns the number of new associations.
int match_by_projection(const MapView& view, const PosePrediction& pose, const Camera& camera,
                        const MatchingParams& params, const Tracks& tracks,
                        LandmarkTable& landmarks);

}  // namespace pirvs
