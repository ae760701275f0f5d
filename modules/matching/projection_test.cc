#include "modules/matching/projection.h"

#include <gtest/gtest.h>

#include <memory>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;

Descriptor random_descriptor(Random& random) {
  Descriptor d;
  for (uint64_t& w : d.w) w = (uint64_t{random.engine()} << 32) | random.engine();
  return d;
}

Descriptor flipped(Descriptor d, int bits) {
  for (int i = 0; i < bits; ++i) d.w[i % 4] ^= uint64_t{1} << (i / 4 * 3);
  return d;
}

// Points before the left camera and tracks exactly where it sees them.
struct Scene {
  explicit Scene(int count, CameraModel model = CameraModel::kPinholeRadtan) : rig(model) {
    while (static_cast<int>(snapshot->points.size()) < count) {
      const double x = random.uniform(2, 8);
      add(Vec3(x, random.uniform(-0.6, 0.6) * x, random.uniform(-0.4, 0.4) * x));
    }
    assign();
  }
  void add(const Vec3& p_W) {
    Vec2 uv;
    if (!rig.see(T_WB, 0, p_W, uv)) return;
    MapPoint point{};
    point.id.slot = static_cast<uint16_t>(3 * snapshot->points.size());
    point.id.generation = 5;
    point.p_W = p_W;
    point.descriptor = random_descriptor(random);
    const Vec3 towards = (T_WB * rig.camera[0].T_BC).p - p_W;
    point.distance_m = static_cast<float>(towards.norm());
    point.view_W = towards.normalized();
    ASSERT_TRUE(snapshot->points.push_back(point));
    add_track(uv, point.descriptor);
  }
  void add_track(const Vec2& uv, const Descriptor& descriptor) {
    Track track;
    track.id = static_cast<TrackId>(tracks.size() + 1);
    track.slot = static_cast<uint16_t>(tracks.size());
    track.x = static_cast<float>(uv.x());
    track.y = static_cast<float>(uv.y());
    track.described = true;
    track.descriptor = descriptor;
    ASSERT_TRUE(tracks.push_back(track));
  }
  void assign() { view->assign(*snapshot, T_WB, rig.camera, kCamerasMax); }
  int match() { return match_by_projection(*view, pose, rig.camera[0], params, tracks, landmarks); }
  LandmarkId shown(size_t i) const { return landmarks.get(tracks[i]); }
  int right() const {
    int count = 0;
    for (size_t i = 0; i < snapshot->points.size(); ++i) {
      count += shown(i) == snapshot->points[i].id ? 1 : 0;
    }
    return count;
  }

  Random random{11};
  Rig rig;
  SE3 T_WB;
  PosePrediction pose;
  MatchingParams params;
  Tracks tracks;
  LandmarkTable landmarks;
  std::unique_ptr<MapSnapshot> snapshot = std::make_unique<MapSnapshot>();
  std::unique_ptr<MapView> view = std::make_unique<MapView>();
};

TEST(projection, finds_every_point_again) {
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    Scene s(100, model);
    EXPECT_EQ(s.match(), 100);
    EXPECT_EQ(s.right(), 100);
    EXPECT_EQ(s.match(), 0) << "all are taken";
  }
}

TEST(projection, handles_find_their_point_and_stale_ones_nothing) {
  Scene s(10);
  for (const MapPoint& point : s.snapshot->points) EXPECT_EQ(s.view->find(point.id), &point);
  LandmarkId id = s.snapshot->points[4].id;
  ++id.generation;
  EXPECT_EQ(s.view->find(id), nullptr);
  EXPECT_EQ(s.view->find(LandmarkId{}), nullptr);
  id.slot = 1;  // no point lives there
  EXPECT_EQ(s.view->find(id), nullptr);
  s.view->clear();
  EXPECT_TRUE(s.view->empty());
  EXPECT_EQ(s.view->find(s.snapshot->points[4].id), nullptr);
  EXPECT_EQ(s.match(), 0);
}

TEST(projection, window_grows_with_the_uncertainty_of_the_pose) {
  Scene s(50);
  s.params.match_radius_px_min = 2;
  s.params.match_radius_px_max = 30;
  for (Track& track : s.tracks) track.x += 9;
  EXPECT_EQ(s.match(), 0) << "a certain pose: 2 px";
  s.pose.cov.diagonal().head<3>().setConstant(0.01 * 0.01);  // 3 sigma: 14 px
  EXPECT_GE(s.match(), 48);
  EXPECT_GE(s.right(), 48);
}

TEST(projection, window_is_never_larger_than_its_limit) {
  Scene s(50);
  s.params.match_radius_px_max = 8;
  for (Track& track : s.tracks) track.x += 9;
  s.pose.cov.diagonal().setConstant(1);
  EXPECT_LT(s.right() + s.match(), 5);
  EXPECT_EQ(s.right(), 0);
}

TEST(projection, far_descriptors_are_no_match) {
  Scene s(40);
  s.params.match_distance_max = 60;
  for (size_t i = 0; i < 40; ++i) {
    s.tracks[i].descriptor = flipped(s.tracks[i].descriptor, i < 20 ? 50 : 70);
  }
  EXPECT_EQ(s.match(), 20);
  for (size_t i = 0; i < 40; ++i) EXPECT_EQ(s.shown(i).valid(), i < 20) << i;
}

TEST(projection, two_points_alike_in_one_window_are_ambiguous) {
  Scene s(0);
  s.add(Vec3(4, 0, 0));
  const Descriptor d = s.snapshot->points[0].descriptor;
  s.add(Vec3(4, 0.005, 0));
  s.snapshot->points[1].descriptor = flipped(d, 2);
  s.tracks.resize(1);
  s.tracks[0].descriptor = flipped(d, 30);
  s.assign();
  EXPECT_EQ(s.match(), 0);
  s.tracks[0].descriptor = d;  // now the first is clearly the better one
  EXPECT_EQ(s.match(), 1);
  EXPECT_EQ(s.shown(0), s.snapshot->points[0].id);
}

TEST(projection, one_point_goes_to_the_better_of_two_tracks) {
  Scene s(1);
  const Descriptor d = s.tracks[0].descriptor;
  s.add_track(Vec2(s.tracks[0].x + 1, s.tracks[0].y), flipped(d, 4));
  s.tracks[0].descriptor = flipped(d, 12);
  EXPECT_EQ(s.match(), 1);
  EXPECT_FALSE(s.shown(0).valid());
  EXPECT_TRUE(s.shown(1).valid());
}

TEST(projection, followed_points_and_undescribed_tracks_are_left_alone) {
  Scene s(3);
  s.landmarks[s.tracks[0]] = s.snapshot->points[1].id;
  s.tracks[2].described = false;
  EXPECT_EQ(s.match(), 0) << "point 1 is taken, track 2 has no descriptor";
  EXPECT_EQ(s.shown(0), s.snapshot->points[1].id);
}

TEST(projection, points_seen_from_elsewhere_are_not_compared) {
  Scene side(10), far(10), behind(10);
  for (MapPoint& point : side.snapshot->points) point.view_W = Vec3(0, 0, 1);
  side.assign();
  EXPECT_EQ(side.match(), 0) << "another side";
  for (MapPoint& point : far.snapshot->points) point.distance_m *= 2.5f;
  far.assign();
  EXPECT_EQ(far.match(), 0) << "another distance";
  for (MapPoint& point : behind.snapshot->points) point.p_W.x() *= -1;
  behind.assign();
  EXPECT_EQ(behind.view->local().size(), 0u);
  EXPECT_EQ(behind.match(), 0);
}

}  // namespace
}  // namespace pirvs
