#include "modules/tracking/mono_start.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>
#include <memory>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

constexpr double kKeyframe_s = 0.14;

// One camera that sways in front of points, and what its IMU felt.
struct Case {
  explicit Case(uint32_t seed, CameraModel model = CameraModel::kPinholeRadtan)
      : random(seed), rig(model) {
    for (int i = 0; i < 120; ++i) {
      const double x = random.uniform(2, 6);
      points.push_back(Vec3(x, random.uniform(-0.5, 0.5) * x, random.uniform(-0.35, 0.35) * x));
    }
    sway.b_g = random.vec(0.04);
    sway.b_a = random.vec(0.05);
  }
  Status solve(int count, int camera = 0) {
    imu->clear();
    keyframes.clear();
    const int samples = static_cast<int>(std::lround((count - 1) * kKeyframe_s / 0.005));
    for (int i = 0; i <= samples; ++i) {
      ImuSample sample = sway.imu(i * 0.005);
      sample.w_B += random.vec(2e-3);
      sample.f_B = force_scale * sample.f_B + random.vec(2e-2);
      imu->add(sample);
    }
    for (int k = 0; k < count; ++k) add_keyframe(k * kKeyframe_s, camera);
    solver->configure(rig.camera[camera], camera, ImuNoise{}, TrackerParams{});
    return solver->solve(*imu, {}, keyframes, start);
  }
  void add_keyframe(double t_s, int camera) {
    KeyframeMessage& message = *keyframes.append();
    message = KeyframeMessage{};
    message.state.t = from_seconds(t_s);
    const SE3 T_WB = sway.state(t_s).T_WB;
    for (size_t i = 0; i < points.size(); ++i) {
      Vec2 uv;
      if (!rig.see(T_WB, camera, points[i], uv)) continue;
      uv += random.pixel(0.4);
      if (i < outliers) uv += random.pixel(20);
      Observation o;
      o.track = static_cast<TrackId>(i + 1);
      o.x = static_cast<float>(uv.x());
      o.y = static_cast<float>(uv.y());
      (void)message.observations[camera].push_back(o);
    }
  }
  // True values in B0, the first keyframe's body.
  Vec3 velocity() const { return turned(sway.state(0).v_WB); }
  Vec3 gravity() const { return turned(Vec3(0, 0, -kGravity_m_s2)); }
  Vec3 turned(const Vec3& x_W) const { return sway.state(0).T_WB.R.transpose() * x_W; }

  Random random;
  Rig rig;
  Sway sway;
  double force_scale = 1;
  size_t outliers = 0;
  std::vector<Vec3> points;
  std::unique_ptr<ImuHistory> imu = std::make_unique<ImuHistory>();
  StartKeyframes keyframes;
  std::unique_ptr<MonoStarter> solver = std::make_unique<MonoStarter>();
  MonoStart start;
};

TEST(mono_start, biases_velocity_and_gravity_come_from_one_swaying_camera) {
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
      Case c(seed, model);
      ASSERT_EQ(c.solve(9, static_cast<int>(seed % 2)), Status::kOk) << seed;
      EXPECT_LT((c.start.b_g - c.sway.b_g).norm(), 0.006) << seed;
      EXPECT_LT((c.start.v_B0 - c.velocity()).norm(), 0.08 * c.velocity().norm()) << seed;
      EXPECT_LT((c.start.g_B0 - c.gravity()).norm(), 0.03 * kGravity_m_s2) << seed;
      EXPECT_NEAR(c.start.g_B0.norm(), kGravity_m_s2, 1e-9);
      EXPECT_LT(c.start.residual_px, 0.8);
      EXPECT_GT(c.start.tracks, 50);
    }
  }
}

TEST(mono_start, covariance_contains_the_error) {
  double nees = 0;
  constexpr int kSeeds = 12;
  for (uint32_t seed = 1; seed <= kSeeds; ++seed) {
    Case c(100 + seed);
    ASSERT_EQ(c.solve(9), Status::kOk) << seed;
    const Vec3 e = c.start.v_B0 - c.velocity();
    const Mat3 P = c.start.cov.block<3, 3>(MonoStart::kVel, MonoStart::kVel);
    nees += e.dot(P.inverse() * e) / kSeeds;
    EXPECT_LT(c.start.scale_sigma, 0.1);
    EXPECT_GT(c.start.scale_sigma, 1e-3) << "nothing is known that well";
  }
  EXPECT_LT(nees, 3.0) << "mean over three unknowns";
}

TEST(mono_start, wrong_tracks_do_not_carry_it_away) {
  Case c(7);
  c.outliers = 18;
  ASSERT_EQ(c.solve(9), Status::kOk);
  EXPECT_LT((c.start.v_B0 - c.velocity()).norm(), 0.1 * c.velocity().norm());
  EXPECT_LE(c.start.tracks, 120 - 15);
}

// Constant speed looks the same at every scale: the solution must know that it does not know.
// Where there is no fit at all, the points have collapsed onto the camera.
TEST(mono_start, without_acceleration_there_is_no_scale) {
  int fits = 0;
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    Case c(seed);
    c.sway.amplitude_m = Vec3(0, 40, 0);
    c.sway.omega_rad_s = Vec3(0, 0.02, 0);
    c.sway.omega_angle_rad_s.setZero();
    for (Vec3& point : c.points) point += c.sway.state(0).T_WB.p;  // in front of the camera
    const Status status = c.solve(9);
    ASSERT_TRUE(status == Status::kBadData || status == Status::kStale) << seed << name(status);
    if (status == Status::kStale) continue;
    ++fits;
    EXPECT_GT(c.start.scale_sigma, 0.1) << seed;
    EXPECT_GT(c.start.tracks, 20) << seed;
  }
  EXPECT_GE(fits, 3);
}

TEST(mono_start, without_parallax_there_is_nothing) {
  Case c(9);
  c.sway.amplitude_m.setZero();
  for (Vec3& point : c.points) point *= 50;
  EXPECT_EQ(c.solve(9), Status::kEmpty);
}

TEST(mono_start, forces_that_do_not_fit_are_no_start) {
  Case c(10);
  c.force_scale = 1.4;
  EXPECT_NE(c.solve(9), Status::kOk);
}

TEST(mono_start, few_tracks_or_keyframes_are_empty) {
  Case c(11);
  EXPECT_EQ(c.solve(3), Status::kEmpty);
  c.points.resize(15);
  EXPECT_EQ(c.solve(9), Status::kEmpty);
}

// The state's covariance at a later keyframe agrees with what moving the unknowns does to it.
TEST(mono_start, state_covariance_follows_the_unknowns) {
  Case c(12);
  ASSERT_EQ(c.solve(9), Status::kOk);
  const TimeNs t = c.keyframes.back().state.t;
  const Preintegration motion = integrate(*c.imu, 0, t, c.start.b_g, c.start.b_a, ImuNoise{});
  const Mat15 cov = mono_start_cov(c.start, motion, Mat3::Identity());
  EXPECT_LT((cov - cov.transpose()).norm(), 1e-12);
  const double h = 1e-4;
  Eigen::Matrix<double, 3, MonoStart::kUnknowns> J;  // of the velocity; W is B0 tilted by gravity
  for (int k = 0; k < MonoStart::kUnknowns; ++k) {
    Vec3 v[2];
    for (const int side : {0, 1}) {
      MonoStart s = c.start;
      Eigen::Matrix<double, MonoStart::kUnknowns, 1> d;
      d.setZero();
      d[k] = side == 0 ? -h : h;
      s.b_g += d.segment<3>(MonoStart::kBg);
      s.b_a += d.segment<3>(MonoStart::kBa);
      s.v_B0 += d.segment<3>(MonoStart::kVel);
      s.g_B0 += s.g_tangent * d.segment<2>(MonoStart::kGravity);
      // The smallest turn that brings the moved gravity back to where it was.
      const Vec3 axis = s.g_B0.cross(c.start.g_B0) / c.start.g_B0.squaredNorm();
      const Preintegration::Motion m = motion.at(s.b_g, s.b_a);
      v[side] = so3_exp(axis) * (s.v_B0 + motion.dt_s * s.g_B0 + m.dv);
    }
    J.col(k) = (v[1] - v[0]) / (2 * h);
  }
  const Mat3 expected = J * c.start.cov * J.transpose() + 0.02 * 0.02 * Mat3::Identity();
  EXPECT_LT((cov.block<3, 3>(6, 6) - expected).norm(), 1e-3 * expected.norm());
}

}  // namespace
}  // namespace pirvs
