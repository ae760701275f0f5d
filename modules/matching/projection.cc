#include "modules/matching/projection.h"

#include <algorithm>
#include <cmath>

#include "core/kernels/hamming/hamming.h"

namespace pirvs {
namespace {

constexpr uint16_t kNone = UINT16_MAX;

struct Best {
  LandmarkId landmark;
  int distance = 257, second = 257;
};

// A descriptor is worth comparing from about the side and the distance it was taken at.
bool seen_alike(const MapPoint& point, const Vec3& p_WC) {
  const Vec3 towards = p_WC - point.p_W;
  const double distance = towards.norm();
  if (distance < 0.5 * point.distance_m || distance > 2.0 * point.distance_m) return false;
  return towards.dot(point.view_W) > 0.7 * distance;
}

}  // namespace

void MapView::clear() {
  snapshot_ = nullptr;
  local_.clear();
  own_points_ = 0;
}

void MapView::assign(const MapSnapshot& snapshot, const SE3& T_WB, const Camera* cameras,
                     int count) {
  snapshot_ = &snapshot;
  leveled_ = snapshot.leveled;
  local_.clear();
  own_points_ = 0;
  std::fill(std::begin(index_), std::end(index_), kNone);
  for (size_t i = 0; i < snapshot.points.size(); ++i) {
    const MapPoint& point = snapshot.points[i];
    index_[point.id.slot] = static_cast<uint16_t>(i);
    if (point.epoch != snapshot.epoch) continue;  // its place is not exact to the pose
    ++own_points_;
    for (int c = 0; c < count; ++c) {
      const SE3 T_WC = T_WB * cameras[c].T_BC;
      const Vec3 p_C = T_WC.R.transpose() * (point.p_W - T_WC.p);
      // A cone of 75 degrees about the optical axis outlasts the turn between two snapshots.
      if (p_C.z() < 0.26 * p_C.norm() || !seen_alike(point, T_WC.p)) continue;
      (void)local_.push_back(static_cast<uint16_t>(i));  // as large as the map: never full
      break;
    }
  }
}

const MapPoint* MapView::find(LandmarkId id) const {
  if (snapshot_ == nullptr || !id.valid() || index_[id.slot] == kNone) return nullptr;
  const MapPoint& point = snapshot_->points[index_[id.slot]];
  return point.id == id ? &point : nullptr;
}

int match_by_projection(const MapView& view, const PosePrediction& pose, const Camera& camera,
                        const MatchingParams& params, const Tracks& tracks,
                        LandmarkTable& landmarks) {
  FixedVector<uint16_t, kTracksMax> open;  // tracks that look for a point
  static_assert(kLandmarksMax % 64 == 0);
  uint64_t taken[kLandmarksMax / 64] = {};  // points that a track already follows, by slot
  for (size_t i = 0; i < tracks.size(); ++i) {
    const LandmarkId id = landmarks.get(tracks[i]);
    if (id.valid()) {
      taken[id.slot / 64] |= uint64_t{1} << (id.slot % 64);
    } else if (tracks[i].described) {
      (void)open.push_back(static_cast<uint16_t>(i));
    }
  }
  if (open.empty()) return 0;
  const SE3 T_WC = pose.T_WB * camera.T_BC;
  const SE3 T_CW = T_WC.inverse();
  const double var_theta = pose.cov.diagonal().head<3>().maxCoeff();
  const double var_p = pose.cov.diagonal().tail<3>().maxCoeff();
  Best best[kTracksMax];
  for (const uint16_t index : view.local()) {
    const MapPoint& point = view.point(index);
    if (taken[point.id.slot / 64] >> (point.id.slot % 64) & 1) continue;
    const Vec3 p_C = T_CW * point.p_W;
    Vec2 uv;
    if (!camera.project(p_C, uv) || !camera.in_image(uv, 0)) continue;
    if (!seen_alike(point, T_WC.p)) continue;
    const double sigma = std::sqrt(var_theta + var_p / p_C.squaredNorm()) * camera.fx;
    const double radius =
        std::min<double>(params.match_radius_px_min + 3 * sigma, params.match_radius_px_max);
    for (const uint16_t i : open) {
      const double dx = tracks[i].x - uv.x(), dy = tracks[i].y - uv.y();
      if (dx * dx + dy * dy > radius * radius) continue;
      const int distance = hamming(tracks[i].descriptor, point.descriptor);
      if (distance < best[i].distance) {
        best[i].second = best[i].distance;
        best[i].distance = distance;
        best[i].landmark = point.id;
      } else {
        best[i].second = std::min(best[i].second, distance);
      }
    }
  }
  int matched = 0;
  for (const uint16_t i : open) {
    if (!is_match(params, best[i].distance, best[i].second)) continue;
    // One point belongs to one track: the better descriptor wins.
    bool beaten = false;
    for (const uint16_t j : open) {
      if (j == i || best[j].landmark != best[i].landmark) continue;
      beaten |=
          best[j].distance < best[i].distance || (best[j].distance == best[i].distance && j < i);
    }
    if (beaten) continue;
    landmarks[tracks[i]] = best[i].landmark;
    ++matched;
  }
  return matched;
}

}  // namespace pirvs
