#include "modules/tracking/starter.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;
using testing::Rig;
using testing::Sway;

constexpr double kFrame_s = 0.05;
constexpr TrackId kRight = 10'000;  // track ids of the right camera begin here

// Points in front of a rig that moves; tracks are their noisy projections.
struct Start {
  explicit Start(int point_count, CameraModel model = CameraModel::kPinholeRadtan) : rig(model) {
    for (int i = 0; i < point_count; ++i) {
      const double x = random.uniform(2, 6);
      points.push_back(Vec3(x, random.uniform(-0.5, 0.5) * x, random.uniform(-0.35, 0.35) * x));
    }
    starter->configure(rig.camera, ImuNoise{}, FilterParams{}, params, imu.get());
    standstill.configure(limits);
    standstill.reset();
    for (int i = 0; i < 48; ++i) {
      Track track;
      track.id = static_cast<TrackId>(i + 1);
      track.slot = static_cast<uint16_t>(i);
      track.x = 47.0f + 94.0f * static_cast<float>(i % 8);
      track.y = 40.0f + 80.0f * static_cast<float>(i / 8);
      (void)seen.push_back(track);
    }
  }

  void look(double t_s) {
    const SE3 T_WB = sway.state(t_s).T_WB;
    for (int c = 0; c < kCamerasMax; ++c) {
      tracks[c].clear();
      observations[c].clear();
      for (size_t i = 0; i < points.size() && !tracks[c].full(); ++i) {
        Vec2 uv;
        if (!rig.see(T_WB, c, points[i], uv)) continue;
        uv += random.pixel(pixel_noise);
        Track track;
        track.id = static_cast<TrackId>(i + 1 + (c == 0 ? 0 : kRight));
        track.x = static_cast<float>(uv.x());
        track.y = static_cast<float>(uv.y());
        (void)tracks[c].push_back(track);
        Observation o;
        o.track = track.id;
        o.x = track.x;
        o.y = track.y;
        (void)observations[c].push_back(o);
      }
    }
    for (size_t l = 0; l < observations[0].size(); ++l) {
      for (size_t r = 0; r < observations[1].size(); ++r) {
        if (observations[1][r].track == observations[0][l].track + kRight) {
          observations[0][l].stereo = static_cast<int16_t>(r);
          observations[1][r].stereo = static_cast<int16_t>(l);
        }
      }
    }
  }

  void feel(double t_s) {
    ImuSample sample = sway.imu(t_s);
    sample.w_B += random.vec(1e-3);
    sample.f_B = force_scale * sample.f_B + random.vec(1e-2);
    imu->add(sample);
  }

  // Frame number k: the samples up to it, then the frame.
  Status frame(int k) {
    for (int i = k == 0 ? 0 : 1; i <= 10; ++i) feel((k - 1) * kFrame_s + i * 0.005);
    const double t_s = k * kFrame_s;
    look(t_s);
    // Standstill has tracks of its own: those above are new in each image.
    for (Track& track : seen) {
      track.x_last = track.x;
      track.x += static_cast<float>(k % 2 == 0 ? image_motion_px : -image_motion_px);
      ++track.age;
    }
    standstill.add_tracks(still_lens, 0, seen, kFrame_s);
    standstill.judge(*imu, kFrame_s, {});
    const bool keyframe = starter->wants_keyframe(from_seconds(t_s));
    return starter->add_frame(from_seconds(t_s), tracks[0], tracks[1],
                              keyframe ? observations : nullptr, standstill, origin);
  }
  // Index of the frame that started, or -1.
  int run(int frames) {
    for (int k = 0; k < frames; ++k) {
      const Status status = frame(k);
      if (status == Status::kOk) return k;
      failures += status == Status::kStale ? 1 : 0;
    }
    return -1;
  }
  double tilt_error(int k) const {
    const Vec3 up = sway.state(k * kFrame_s).T_WB.R.transpose() * Vec3::UnitZ();
    return (starter->state().T_WB.R.transpose() * Vec3::UnitZ() - up).norm();
  }
  double velocity_error(int k) const {
    const BodyState truth = sway.state(k * kFrame_s);
    return (starter->state().T_WB.R.transpose() * starter->state().v_WB -
            truth.T_WB.R.transpose() * truth.v_WB)
        .norm();
  }

  Random random{21};
  Rig rig;
  Sway sway;
  double pixel_noise = 0.3, image_motion_px = 5, force_scale = 1;
  TrackerParams params;
  StandstillParams limits;
  StandstillDetector standstill;
  Camera still_lens = testing::lens(CameraModel::kPinholeRadtan);
  std::unique_ptr<ImuHistory> imu = std::make_unique<ImuHistory>();
  std::unique_ptr<Starter> starter = std::make_unique<Starter>();
  std::vector<Vec3> points;
  Tracks tracks[kCamerasMax], seen;
  Observations observations[kCamerasMax];
  SE3 origin;
  int failures = 0;
};

TEST(starter, in_motion_gravity_gyro_bias_and_velocity_are_found) {
  for (const CameraModel model : {CameraModel::kPinholeRadtan, CameraModel::kKannalaBrandt}) {
    for (uint32_t seed = 1; seed <= 5; ++seed) {
      Start s(150, model);
      s.random = Random(seed);
      s.sway.b_g = s.random.vec(0.03);
      const int k = s.run(60);
      ASSERT_GE(k, 0) << seed;
      EXPECT_LE(k, 39) << "within two seconds";
      EXPECT_FALSE(s.starter->at_rest());
      EXPECT_EQ(s.starter->state().t, from_seconds(k * kFrame_s));
      EXPECT_LT(s.tilt_error(k), 0.03) << seed;
      EXPECT_LT(s.velocity_error(k), 0.08) << seed;
      EXPECT_LT((s.starter->state().b_g - s.sway.b_g).norm(), 0.006) << seed;
      EXPECT_LT(s.starter->state().b_a.norm(), 1e-12);
    }
  }
}

TEST(starter, keyframes_carry_the_motion_in_metres_and_are_linked) {
  Start s(150);
  const int k = s.run(60);
  ASSERT_GE(k, 0);
  const auto& keyframes = s.starter->keyframes();
  ASSERT_GE(keyframes.size(), 6u);
  const auto relative = [](const BodyState& a, const BodyState& b) {
    return Vec3(a.T_WB.R.transpose() * (b.T_WB.p - a.T_WB.p));
  };
  for (size_t i = 1; i < keyframes.size(); ++i) {
    const BodyState &a = keyframes[i - 1].state, &b = keyframes[i].state;
    const BodyState a_true = s.sway.state(to_seconds(a.t)), b_true = s.sway.state(to_seconds(b.t));
    EXPECT_LT((relative(a, b) - relative(a_true, b_true)).norm(), 0.02) << i;
    EXPECT_TRUE(keyframes[i].linked);
    EXPECT_NEAR(keyframes[i].from_previous.dt_s, to_seconds(b.t - a.t), 1e-9);
    EXPECT_FALSE(keyframes[i].restart);
    EXPECT_EQ(keyframes[i].adjust, i + 1 == keyframes.size()) << "one adjustment for all";
  }
  EXPECT_TRUE(keyframes[0].restart);
  EXPECT_FALSE(keyframes[0].linked);
}

TEST(starter, goes_on_from_the_given_place_and_heading) {
  Start s(150);
  s.origin.p = Vec3(3, -2, 1);
  s.origin.R = so3_exp(Vec3(0, 0, 1.2));
  ASSERT_GE(s.run(60), 0);
  const BodyState& first = s.starter->keyframes()[0].state;
  EXPECT_LT((first.T_WB.p - s.origin.p).norm(), 1e-9);
  const Vec3 x_W = first.T_WB.R * Vec3::UnitX();
  EXPECT_NEAR(std::atan2(x_W.y(), x_W.x()), 1.2, 0.15) << "tilted by the sway";
}

TEST(starter, at_rest_gravity_and_bias_come_from_the_imu) {
  Start s(150);
  s.sway.amplitude_m.setZero();
  s.sway.omega_angle_rad_s.setZero();
  s.sway.b_g = Vec3(0.02, -0.03, 0.01);
  s.image_motion_px = 0.05;
  const int k = s.run(60);
  ASSERT_GE(k, 0);
  EXPECT_TRUE(s.starter->at_rest());
  EXPECT_LT(s.tilt_error(k), 0.003);
  EXPECT_LT((s.starter->state().b_g - s.sway.b_g).norm(), 1e-3);
  EXPECT_LT(s.starter->state().v_WB.norm(), 1e-9);
  EXPECT_EQ(s.starter->keyframes().size(), 1u) << "more would say the same";
  EXPECT_LT(k * kFrame_s, s.params.start_s + s.params.start_keyframe_s + kFrame_s);
}

// Coming to rest in the middle of an attempt: what came before does not count.
TEST(starter, rest_counts_from_where_it_began) {
  Start s(150);
  s.sway.amplitude_m.setZero();
  s.sway.omega_angle_rad_s.setZero();
  int k = 0;
  for (; k < 3; ++k) EXPECT_EQ(s.frame(k), Status::kEmpty) << k;
  s.image_motion_px = 0.05;
  Status status = Status::kEmpty;
  while (status == Status::kEmpty && k < 60) status = s.frame(k++);
  EXPECT_EQ(status, Status::kOk);
  EXPECT_TRUE(s.starter->at_rest());
  EXPECT_GE(s.starter->state().t, from_seconds(2 * kFrame_s + s.params.start_s));
}

TEST(starter, too_few_points_are_stale) {
  Start s(15);
  EXPECT_EQ(s.frame(0), Status::kStale);
  EXPECT_EQ(s.run(40), -1);
  EXPECT_EQ(s.failures, 40);
}

TEST(starter, losing_the_points_ends_the_attempt_and_the_next_one_works) {
  Start s(150);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(s.frame(k), Status::kEmpty) << k;
  std::vector<Vec3> points;
  std::swap(points, s.points);
  EXPECT_EQ(s.frame(5), Status::kStale);
  std::swap(points, s.points);
  Status status = Status::kEmpty;
  for (int k = 6; k < 60 && status == Status::kEmpty; ++k) status = s.frame(k);
  EXPECT_EQ(status, Status::kOk);
  EXPECT_GE(s.starter->keyframes()[0].state.t, from_seconds(6 * kFrame_s));
}

TEST(starter, a_frame_without_its_imu_sample_is_stale) {
  Start s(150);
  s.look(0);
  EXPECT_EQ(s.starter->add_frame(0, s.tracks[0], s.tracks[1], s.observations, s.standstill, {}),
            Status::kStale);
  s.feel(0);
  EXPECT_EQ(s.starter->add_frame(1, s.tracks[0], s.tracks[1], s.observations, s.standstill, {}),
            Status::kStale);
}

// Forces that do not fit gravity and what is seen: it keeps looking, and never starts.
TEST(starter, forces_that_do_not_fit_never_start) {
  Start s(150);
  s.force_scale = 1.4;
  EXPECT_EQ(s.run(90), -1);
  EXPECT_GE(s.failures, 1);
}

TEST(starter, covariance_covers_what_it_found) {
  Start s(150);
  const int k = s.run(60);
  ASSERT_GE(k, 0);
  const Vec15 sigma = s.starter->cov().diagonal().cwiseSqrt();
  EXPECT_LT(s.tilt_error(k), 3 * sigma[0]);
  EXPECT_LT(s.velocity_error(k), 3 * sigma[6]);
  EXPECT_LT((s.starter->state().b_g - s.sway.b_g).norm(), 3 * sigma[9]);
}

}  // namespace
}  // namespace pirvs
