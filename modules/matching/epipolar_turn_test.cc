#include "modules/matching/epipolar_turn.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/math/so3.h"
#include "core/math/trig.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;

constexpr double kDegree = kPi / 180;

// A rig whose right camera stands turned about its own axes by turn_C1, and points 2 to 8 m away
// all over the left image.
struct Bent {
  Bent(const Vec3& turn_C1, uint32_t seed) : random(seed), T_BC1(rig.camera[1].T_BC) {
    T_BC1.R = T_BC1.R * so3_exp(turn_C1);
    turn.configure(rig.camera[0], rig.camera[1]);
  }
  // The next point, where both see it; false: the right one does not.
  bool next(Vec3& f_C0, Vec2& uv_right) {
    const Vec2 uv(random.uniform(20, 730), random.uniform(20, 460));
    if (!rig.camera[0].unproject(uv, f_C0)) return false;
    const Vec3 p_B = rig.camera[0].T_BC * Vec3(random.uniform(2, 8) * f_C0);
    f_C0.normalize();
    return rig.camera[1].project(T_BC1.inverse() * p_B, uv_right);
  }
  bool bearing(const Vec2& uv_right, Vec3& f_C1) const {
    const bool ok = rig.camera[1].unproject(uv_right, f_C1);
    f_C1.normalize();
    return ok;
  }
  Rig rig{CameraModel::kPinholeRadtan};
  Random random;
  SE3 T_BC1;
  EpipolarTurn turn;
};

// A share of the points matched with anything near by.
EpipolarTurn seen(const Vec3& turn_C1, int matches = 400, double strays = 0.1) {
  Bent bent(turn_C1, 5);
  for (int i = 0; i < matches; ++i) {
    Vec3 f_C0, f_C1;
    Vec2 uv_right;
    if (!bent.next(f_C0, uv_right)) continue;
    uv_right += bent.random.pixel(bent.random.uniform(0, 1) < strays ? 20 : 0.3);
    if (bent.bearing(uv_right, f_C1)) bent.turn.add(f_C0, f_C1);
  }
  return bent.turn;
}

TEST(epipolar_turn, cameras_that_stand_as_calibrated_agree) {
  const EpipolarTurn turn = seen(Vec3::Zero());
  EXPECT_LT(turn.turn_B().norm(), 0.1 * kDegree);
  EXPECT_FALSE(turn.disagrees());
  EXPECT_FALSE(seen(Vec3(0.1 * kDegree, 0, 0.1 * kDegree)).disagrees());
}

TEST(epipolar_turn, one_that_is_bent_is_told_by_how_much) {
  const Rig rig(CameraModel::kPinholeRadtan);
  for (const Vec3& degrees : {Vec3(0.5, 0, 0), Vec3(-1, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, -0.5),
                              Vec3(0, 1, 0), Vec3(0.4, 0.3, -0.6)}) {
    const EpipolarTurn turn = seen(degrees * kDegree);
    SCOPED_TRACE(::testing::PrintToString(degrees.x()) + " " +
                 ::testing::PrintToString(degrees.y()) + " " +
                 ::testing::PrintToString(degrees.z()));
    EXPECT_TRUE(turn.disagrees());
    const Vec3 turn_B = rig.camera[1].T_BC.R * degrees * kDegree;
    EXPECT_LT((turn.turn_B() - turn_B).norm(), 0.15 * kDegree);
  }
}

TEST(epipolar_turn, strays_and_few_matches_tell_nothing) {
  EXPECT_FALSE(seen(Vec3::Zero(), 400, 1.0).disagrees());
  EXPECT_FALSE(seen(Vec3(kDegree, 0, 0), 20).disagrees());
}

// Points that look alike, of which a share are not the same.
EpipolarTurn looked(const Vec3& turn_C1, int count, double wrong) {
  Bent bent(turn_C1, 6);
  Random& random = bent.random;
  std::vector<EpipolarTurn::Look> looks;
  while (static_cast<int>(looks.size()) < count) {
    EpipolarTurn::Look look;
    Vec2 uv;
    if (!bent.next(look.f_C0, uv)) continue;
    if (random.uniform(0, 1) < wrong) uv = Vec2(random.uniform(20, 730), random.uniform(20, 460));
    if (bent.bearing(uv + random.pixel(0.5), look.f_C1)) looks.push_back(look);
  }
  bent.turn.add_looks(looks.data(), count);
  return bent.turn;
}

TEST(epipolar_turn, far_off_the_curves_looks_tell) {
  const Rig rig(CameraModel::kPinholeRadtan);
  for (const Vec3& degrees : {Vec3(1.5, 0, 0), Vec3(-4, 0, 0), Vec3(2, 3, -5)}) {
    const EpipolarTurn turn = looked(degrees * kDegree, 40, 0.3);
    EXPECT_TRUE(turn.disagrees()) << degrees.x();
    const Vec3 off = turn.turn_B() - rig.camera[1].T_BC.R * degrees * kDegree;
    EXPECT_LT(off.norm(), 0.4 * kDegree) << degrees.x();
  }
  EXPECT_FALSE(looked(Vec3::Zero(), 40, 0.3).disagrees());
  EXPECT_FALSE(looked(Vec3(2 * kDegree, 0, 0), 8, 0).disagrees()) << "few";
  EXPECT_FALSE(looked(Vec3(2 * kDegree, 0, 0), 60, 0.8).disagrees()) << "most of them are wrong";
}

TEST(epipolar_turn, is_asked_anew_after_a_while) {
  EpipolarTurn turn = seen(Vec3(kDegree, 0, 0));
  ASSERT_TRUE(turn.disagrees());
  turn.forget();
  EXPECT_FALSE(turn.disagrees());
}

}  // namespace
}  // namespace pirvs
