#include "modules/mapping/new_points.h"

#include "modules/matching/triangulate.h"

namespace pirvs {
namespace {

constexpr int kViewsMax = 8;
constexpr size_t kKeyframesBack = 6;

// All views of one track that has no point yet: here, in the other camera, in the last keyframes.
struct Sightings {
  View views[kViewsMax];
  Observation* observations[kViewsMax];
  int count = 0;

  void add(const Keyframe& from, const Camera& camera, Observation& sighting) {
    const SE3 T_CW = (from.state.T_WB * camera.T_BC).inverse();
    views[count] = {&camera, T_CW, Vec2(sighting.x, sighting.y)};
    observations[count++] = &sighting;
  }
};

void gather(WorkingMap& map, const Camera* cameras, int camera, size_t index, Sightings& out) {
  Keyframe& newest = map.newest();
  Observation& here = newest.observations[camera][index];
  out.add(newest, cameras[camera], here);
  if (here.stereo >= 0) {
    Observation& other = newest.observations[1 - camera][static_cast<size_t>(here.stereo)];
    if (!other.landmark.valid()) out.add(newest, cameras[1 - camera], other);
  }
  const size_t last = map.size() - 1;
  for (size_t back = 1; back <= last && back <= kKeyframesBack && out.count < kViewsMax; ++back) {
    Keyframe& earlier = map.keyframe(last - back);
    // What it saw since was never linked to here.
    if (earlier.sequence < map.run_sequence()) break;
    bool seen = false;
    for (Observation& sighting : earlier.observations[camera]) {
      if (sighting.track != here.track || sighting.landmark.valid()) continue;
      out.add(earlier, cameras[camera], sighting);
      seen = true;
      break;
    }
    if (!seen) break;  // a track is never interrupted
  }
}

void create_point(WorkingMap& map, const Camera* cameras, int camera, size_t index,
                  const MappingParams& params, MappingCounters& counters) {
  Sightings seen;
  gather(map, cameras, camera, index, seen);
  if (seen.count < 2) return;
  const bool stereo = seen.views[0].camera != seen.views[1].camera;
  Triangulated point;
  const float parallax_min = stereo ? params.stereo_parallax_rad_min : params.parallax_rad_min;
  if (!triangulate(seen.views, seen.count, params.sigma_px, point) ||
      point.parallax_rad < parallax_min || point.residual_px_max > params.new_point_residual_px) {
    ++counters.points_rejected;
    return;
  }
  const Result<LandmarkId> id = map.points().acquire();
  if (!id.ok()) {
    ++counters.points_full;
    return;
  }
  const Keyframe& newest = map.newest();
  const Observation& here = newest.observations[camera][index];
  Landmark& landmark = *map.points().find(id.value());
  landmark = Landmark{};
  landmark.p_W = point.p_W;
  landmark.cov = point.cov;
  landmark.descriptor = here.descriptor;
  const Vec3 towards = (newest.state.T_WB * cameras[camera].T_BC).p - point.p_W;
  landmark.distance_m = static_cast<float>(towards.norm());
  landmark.view_W = towards / towards.norm();
  landmark.first_keyframe = landmark.last_keyframe = newest.sequence;
  landmark.epoch = newest.epoch;
  landmark.track[camera] = here.track;
  if (stereo) landmark.track[1 - camera] = seen.observations[1]->track;
  for (int i = 0; i < seen.count; ++i) {
    WorkingMap::attach(*seen.observations[i], id.value(), landmark);
  }
  ++(stereo ? counters.points_stereo : counters.points_temporal);
}

}  // namespace

void create_points(WorkingMap& map, const Camera* cameras, const MappingParams& params,
                   MappingCounters& counters) {
  for (int c = 0; c < kCamerasMax; ++c) {
    const Observations& observations = map.newest().observations[c];
    for (size_t i = 0; i < observations.size(); ++i) {
      if (observations[i].landmark.valid() || !observations[i].described) continue;
      create_point(map, cameras, c, i, params, counters);
    }
  }
}

}  // namespace pirvs
