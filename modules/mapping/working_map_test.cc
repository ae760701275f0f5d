#include "modules/mapping/working_map.h"

#include <gtest/gtest.h>

#include <memory>

#include "modules/testing.h"

namespace pirvs {
namespace {

SE3 tilt_about(const Vec3& at, const Vec3& turn) {
  SE3 T;
  T.R = so3_exp(turn);
  T.p = at - T.R * at;
  return T;
}

// Tracking sends a keyframe before it has heard that the map was leveled.
TEST(working_map, a_keyframe_of_the_world_before_a_tilt_is_taken_along) {
  testing::Random random(1);
  auto map = std::make_unique<WorkingMap>();
  KeyframeMessage first;
  first.sequence = 1;
  first.state = random.state();
  map->append(first);
  const SE3 once = tilt_about(random.vec(1.0), Vec3(0.01, -0.02, 0));
  const SE3 twice = tilt_about(random.vec(1.0), Vec3(-0.01, 0.005, 0));
  map->level(once);
  KeyframeMessage second;
  second.sequence = 2;
  second.state = random.state();
  second.leveled = once;
  map->level(twice);
  BodyState expected = second.state;
  move(twice, expected);
  EXPECT_LT(boxminus(map->append(second).state, expected).norm(), 1e-12);
  BodyState moved = first.state;
  move(once, moved);
  move(twice, moved);
  EXPECT_LT(boxminus(map->keyframe(0).state, moved).norm(), 1e-12);
  KeyframeMessage third = second;
  third.sequence = 3;
  third.leveled = map->leveled();
  EXPECT_LT(boxminus(map->append(third).state, second.state).norm(), 1e-12) << "it knew";
}

}  // namespace
}  // namespace pirvs
