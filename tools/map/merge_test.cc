#include "tools/map/merge.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/math/so3.h"
#include "modules/map/nodes.h"
#include "modules/testing.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

using pirvs::testing::Random;

// A point of the hall looks the same to whoever sees it, but for a few bits.
Descriptor look(int number, Random& random) {
  Random own(1000 + uint64_t(number));
  Descriptor out{};
  for (uint64_t& word : out.w) {
    for (int bit = 0; bit < 64; ++bit) word |= uint64_t(own.uniform(0, 1) > 0.5) << bit;
  }
  for (int i = 0; i < 12; ++i)
    out.w[size_t(random.uniform(0, 4))] ^= 1ull << int(random.uniform(0, 64));
  return out;
}

Vec3 place(int number) {
  Random own(5000 + uint64_t(number));
  return own.vec(6);
}

// Points first to last of the hall, each known to 1 cm, in a frame that stands at T; one keyframe
// that sees them.
std::unique_ptr<Map> map_of(int first, int last, const SE3& T, uint64_t seed) {
  auto map = std::make_unique<Map>();
  Random random(seed);
  Keyframe& keyframe = *map->keyframes.find(map->keyframes.acquire().value());
  keyframe.sequence = 7;
  keyframe.epoch = 2;
  keyframe.state.T_WB = T.inverse();
  for (int i = first; i < last; ++i) {
    const LandmarkId id = map->landmarks.acquire().value();
    Landmark& point = *map->landmarks.find(id);
    point.p_W = T.inverse() * place(i) + random.vec(0.01);
    point.cov = 1e-4 * Mat3::Identity();
    point.descriptor = look(i, random);
    point.epoch = 2;
    if (keyframe.observations[0].full()) continue;
    Observation& o = *keyframe.observations[0].append();
    o = Observation{};
    o.landmark = id;
    ++point.views;
  }
  return map;
}

TEST(map_merge, lays_one_map_on_the_other_where_both_know_the_same) {
  const SE3 first{}, second{so3_exp(Vec3(0, 0, 1.2)), Vec3(3, -1, 0.4)};
  const auto a = map_of(0, 400, first, 1);
  const auto b = map_of(250, 600, second, 2);
  ASSERT_EQ(set_node(*b, "dock", second.inverse() * SE3{Mat3::Identity(), Vec3(1, 2, 3)}, 2),
            Status::kOk);
  const MergeReport report = merge_maps(*a, *b);
  EXPECT_GT(report.shared, 120u) << "of 150";
  EXPECT_LT((report.T_AB.p - second.p).norm(), 0.01);
  EXPECT_LT(so3_log(report.T_AB.R.transpose() * second.R).norm(), 0.002);
  EXPECT_EQ(a->landmarks.size(), 400 + 350 - report.shared);
  ASSERT_EQ(a->keyframes.size(), 2u);
  EXPECT_EQ(a->keyframes.at(1)->sequence, 14u);
  EXPECT_EQ(a->keyframes.at(1)->epoch, 2);
  EXPECT_LT(a->keyframes.at(1)->state.T_WB.p.norm(), 0.01) << "both stood at the same place";
  EXPECT_LT((node_pose(*a, "dock").value().p - Vec3(1, 2, 3)).norm(), 0.02);
  int seen_by_both = 0;
  for (size_t slot = 0; slot < a->landmarks.capacity(); ++slot) {
    const Landmark* point = a->landmarks.at(slot);
    if (point != nullptr && point->views == 2) ++seen_by_both;
  }
  EXPECT_GT(seen_by_both, 0);
}

TEST(map_merge, refuses_maps_of_different_places) {
  const auto a = map_of(0, 400, SE3{}, 1), b = map_of(400, 800, SE3{}, 2);
  EXPECT_THROW(merge_maps(*a, *b), InputError);
}

}  // namespace
}  // namespace pirvs::tools
