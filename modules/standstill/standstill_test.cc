#include "modules/standstill/standstill.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "modules/imu/gravity.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Random;

constexpr int kWidth = 752;
constexpr double kFrame_s = 0.05;

// Four tracks in each of the 48 cells; at rest they jitter about their places.
struct Case {
  Case() {
    detector.configure(params);
    detector.reset();
    for (int i = 0; i < 48 * 4; ++i) {
      Track track;
      track.id = static_cast<TrackId>(i + 1);
      track.slot = static_cast<uint16_t>(i);
      const int column = i % 8, row = i / 8 % 6, right = i / 48 % 2, below = i / 96;
      track.x = 20.0f + static_cast<float>(94 * column + 30 * right);
      track.y = 20.0f + static_cast<float>(80 * row + 30 * below);
      (void)tracks.push_back(track);
      (void)place.push_back(Vec2(track.x, track.y));
      (void)home.push_back(place.back());
    }
  }

  // flow(home, place): how far a track goes in this image; home is where it was at first.
  template <class Flow>
  bool frame(const Flow& flow) {
    for (int i = 0; i < 10; ++i) {
      imu->add({t += 5'000'000, w_B + random.vec(sigma_w), f_B + random.vec(sigma_f)});
    }
    for (size_t i = 0; i < tracks.size(); ++i) {
      Track& track = tracks[i];
      track.x_last = track.x;
      track.y_last = track.y;
      place[i] += flow(home[i], place[i]);
      const Vec2 at = place[i] + random.pixel(jitter_px);
      track.x = static_cast<float>(at.x());
      track.y = static_cast<float>(at.y());
      ++track.age;
    }
    detector.add_tracks(camera, 0, tracks, kFrame_s);
    detector.judge(*imu, kFrame_s, expected);
    return detector.at_rest();
  }
  bool still() {
    return frame([](const Vec2&, const Vec2&) { return Vec2(0, 0); });
  }
  // The frame at which it is at rest, or none of `frames`.
  int run_to_rest(int frames) {
    for (int k = 1; k <= frames; ++k) {
      if (still()) return k;
    }
    return 0;
  }

  Camera camera = testing::lens(CameraModel::kPinholeRadtan);
  StandstillParams params;
  std::unique_ptr<ImuHistory> imu = std::make_unique<ImuHistory>();
  StandstillDetector detector;
  StandstillDetector::Expected expected;
  Random random{6};
  Vec3 w_B = Vec3(0.02, -0.01, 0.03), f_B = Vec3(0.5, 0.3, 9.78);
  double sigma_w = 0.002, sigma_f = 0.03, jitter_px = 0.05;
  TimeNs t = 0;
  Tracks tracks;
  FixedVector<Vec2, kTracksMax> home, place;
};

TEST(standstill, rest_is_seen_and_its_means_are_measured) {
  Case c;
  const int k = c.run_to_rest(40);
  ASSERT_GT(k, 0);
  EXPECT_NEAR(k * kFrame_s, c.params.image_s, kFrame_s + 1e-6);
  EXPECT_NEAR(c.detector.rest_s(), c.params.image_s, 1e-6);
  EXPECT_LT((c.detector.mean_rate_B() - c.w_B).norm(), 0.002);
  EXPECT_LT((c.detector.last_rate_B() - c.w_B).norm(), 0.003);
  EXPECT_LT((c.detector.mean_force_B() - c.f_B).norm(), 0.02);
  EXPECT_LT((c.detector.last_force_B() - c.f_B).norm(), 0.04);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(c.still());
  EXPECT_NEAR(c.detector.rest_s(), c.params.image_s + 1, 1e-6);
}

TEST(standstill, needs_a_full_window_of_samples) {
  Case c;
  c.params.window_samples = 200;  // 20 frames
  c.detector.configure(c.params);
  EXPECT_EQ(c.run_to_rest(40), 20);
}

TEST(standstill, each_restless_sign_of_the_imu_alone_denies_it) {
  Case turning, shaking, falling;
  turning.sigma_w = 0.05;
  EXPECT_EQ(turning.run_to_rest(100), 0);
  shaking.sigma_f = 0.5;
  EXPECT_EQ(shaking.run_to_rest(100), 0) << "a scene that is shaken with the device";
  falling.f_B = Vec3(0, 0, 8.8);
  EXPECT_EQ(falling.run_to_rest(100), 0) << "a lift that speeds up";
}

// All of the image moves, the IMU is as quiet as at rest.
TEST(standstill, a_steady_flight_is_no_rest) {
  for (const double px : {0.06, 0.2, 1.0, 8.0}) {
    Case c;
    for (int k = 0; k < 200; ++k) {
      const auto flow = [&](const Vec2&, const Vec2&) { return Vec2(px, 0.3 * px); };
      EXPECT_FALSE(c.frame(flow)) << px << " px, " << k;
    }
  }
}

// Towards what is seen, flow grows from the middle of the image outwards: 0.1 m/s at 5 m.
TEST(standstill, a_steady_flight_ahead_is_no_rest) {
  Case c;
  for (int k = 0; k < 200; ++k) {
    const auto flow = [&](const Vec2&, const Vec2& p) -> Vec2 {
      return (p - Vec2(376, 240)) * (0.1 * kFrame_s / 5);
    };
    EXPECT_FALSE(c.frame(flow)) << k;
  }
}

Vec2 to_and_fro(int k) { return Vec2(4.0 * std::cos(0.1 * k), 0); }

// A third of the cells, which hold most of the tracks.
TEST(standstill, an_object_that_attracts_the_tracks_does_not_hide_rest) {
  Case c;
  size_t kept = 0;
  for (size_t i = 0; i < c.tracks.size(); ++i) {
    const bool on_object = c.place[i].x() < kWidth / 3.0;
    if (!on_object && i >= 48) continue;  // elsewhere one track a cell
    c.tracks[kept] = c.tracks[i];
    c.home[kept] = c.place[kept] = c.place[i];
    ++kept;
  }
  c.tracks.resize(kept);
  c.place.resize(kept);
  c.home.resize(kept);
  const auto on_object = [](const Vec2& p) { return p.x() < kWidth / 3.0; };
  int rested = 0;
  size_t told = 0, wrong = 0;
  for (int k = 0; k < 400; ++k) {
    const auto flow = [&](const Vec2& home, const Vec2&) {
      return on_object(home) ? to_and_fro(k) : Vec2(0, 0);
    };
    rested += c.frame(flow) ? 1 : 0;
  }
  for (size_t i = 0; i < c.tracks.size(); ++i) {
    told += c.detector.moves(0, c.tracks[i]) ? 1 : 0;
    wrong += c.detector.moves(0, c.tracks[i]) && !on_object(c.home[i]) ? 1 : 0;
  }
  EXPECT_GE(rested, 400 - 12);
  EXPECT_GT(told, c.tracks.size() / 3);
  EXPECT_EQ(wrong, 0u);
}

TEST(standstill, an_object_that_fills_the_view_does_hide_it) {
  Case c;
  for (int k = 0; k < 200; ++k) {
    const auto flow = [&](const Vec2& home, const Vec2&) {
      return home.x() < 0.85 * kWidth ? to_and_fro(k) : Vec2(0, 0);
    };
    EXPECT_FALSE(c.frame(flow)) << k;
  }
}

TEST(standstill, slow_motion_of_the_whole_image_ends_it_soon) {
  Case c;
  ASSERT_GT(c.run_to_rest(40), 0);
  for (int k = 0; k < 100; ++k) c.still();
  int k = 1;  // 1 px/s: 1 cm/s, 5 m from what is seen
  while (k < 40 && c.frame([](const Vec2&, const Vec2&) { return Vec2(0.05, 0); })) ++k;
  EXPECT_LE(k * kFrame_s, 0.5);
}

TEST(standstill, a_push_or_a_turn_ends_it_at_once) {
  for (const int kind : {0, 1, 2}) {
    Case c;
    ASSERT_GT(c.run_to_rest(40), 0);
    if (kind == 0) c.f_B.x() += 0.2;   // that changes the force's size by nothing to speak of
    if (kind == 1) c.w_B.z() += 0.15;  // 9 deg/s, with the scene: the image does not show it
    if (kind == 2) c.sigma_f = 1;
    EXPECT_FALSE(c.still()) << kind;
  }
}

// What a turn of the scene along with the device would show of gravity is not there.
TEST(standstill, a_gyro_that_steps_while_the_picture_stands_has_another_bias) {
  Case c;
  ASSERT_GT(c.run_to_rest(40), 0);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(c.still());
  EXPECT_EQ(c.detector.rate_step(), 0);
  const Vec3 step(0.05, -0.05, 0.05);
  c.w_B += step;
  ASSERT_TRUE(c.still());
  EXPECT_NEAR(c.detector.rate_step(), step.norm(), 0.005);
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(c.still()) << k;
    EXPECT_EQ(c.detector.rate_step(), 0) << k;
  }
  for (int k = 0; k < 20; ++k) {  // and no farther than a bias goes
    c.w_B.z() += 0.01;
    c.still();
  }
  EXPECT_FALSE(c.detector.at_rest());
}

// The bias may wander while it stands.
TEST(standstill, the_slow_wander_of_biases_is_no_motion) {
  Case c;
  ASSERT_GT(c.run_to_rest(40), 0);
  for (int k = 0; k < 12'000; ++k) {  // ten minutes
    c.w_B.z() += 0.01 / 12'000;
    c.f_B.x() += 0.2 / 12'000;
    ASSERT_TRUE(c.still()) << k;
  }
}

// A train that has set off smoothly, seen from within: the pose knows that the force is not gravity
// alone. In the end the train is the world.
TEST(standstill, what_the_pose_denies_is_believed_late) {
  for (const bool turning : {false, true}) {
    Case c;
    c.expected = {true, c.w_B, c.f_B};
    (turning ? c.w_B.z() : c.f_B.y()) += turning ? 0.03 : 0.4;
    const int k = c.run_to_rest(100);
    EXPECT_NEAR(k * kFrame_s, c.params.image_s + c.params.patience_s, 0.11);
  }
  Case agreed;
  agreed.expected = {true, agreed.w_B, agreed.f_B};
  EXPECT_NEAR(agreed.run_to_rest(100) * kFrame_s, agreed.params.image_s, 0.051);
}

// Something passes before a tracked point and takes the track along a little; another slides
// slowly.
TEST(standstill, tracks_that_slid_at_rest_are_told) {
  Case c;
  ASSERT_GT(c.run_to_rest(40), 0);
  bool taken = false, slides = false;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(c.frame([&](const Vec2& home, const Vec2&) {
      if ((home - c.home[0]).norm() < 1) return Vec2(k == 20 ? 0.6 : 0.0, 0);
      return Vec2((home - c.home[1]).norm() < 1 ? 0.01 : 0.0, 0);
    }));
    taken |= c.detector.slid(0, c.tracks[0]);
    slides |= c.detector.slid(0, c.tracks[1]);
    EXPECT_FALSE(k < 20 && (taken || slides)) << k;
    for (size_t i = 2; i < c.tracks.size(); ++i) ASSERT_FALSE(c.detector.slid(0, c.tracks[i])) << i;
  }
  EXPECT_TRUE(taken);
  EXPECT_TRUE(slides);
}

// The IMU says that it set off, the image that nothing moved: the vehicle is the world, but late.
TEST(standstill, after_a_push_that_no_image_shows_rest_comes_late) {
  Case c;
  ASSERT_GT(c.run_to_rest(40), 0);
  c.f_B.x() += 0.4;
  EXPECT_NEAR(c.run_to_rest(200) * kFrame_s, c.params.patience_s, 0.3);
  Case returned;
  ASSERT_GT(returned.run_to_rest(40), 0);
  returned.f_B.x() += 0.4;
  returned.still();
  returned.f_B.x() -= 0.4;
  EXPECT_LT(returned.run_to_rest(200) * kFrame_s, 0.5) << "a knock";
}

// A train brakes, a knock does not.
TEST(standstill, what_is_seen_moves_along_when_the_imu_alone_gains_speed) {
  Case train;
  ASSERT_GT(train.run_to_rest(40), 0);
  train.f_B.x() -= 1.5;
  for (int k = 0; k < 5; ++k) train.still();
  EXPECT_FALSE(train.detector.moved_along());
  for (int k = 0; k < 5; ++k) train.still();
  EXPECT_TRUE(train.detector.moved_along());
  train.f_B.x() += 1.5;
  for (int k = 0; k < 200; ++k) train.still();
  EXPECT_TRUE(train.detector.moved_along()) << "for good";
  Case knock;
  ASSERT_GT(knock.run_to_rest(40), 0);
  knock.f_B.x() += 3;
  knock.still();
  knock.f_B.x() -= 6;
  knock.still();
  knock.f_B.x() += 3;
  for (int k = 0; k < 200; ++k) knock.still();
  EXPECT_FALSE(knock.detector.moved_along());
}

TEST(standstill, without_images_there_is_no_rest) {
  Case c;
  ASSERT_GT(c.run_to_rest(40), 0);
  c.tracks.clear();
  EXPECT_FALSE(c.still());
}

TEST(standstill, not_a_number_is_no_rest) {
  Case c;
  c.f_B.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(c.run_to_rest(40), 0);
}

TEST(standstill, reset_forgets) {
  Case c;
  ASSERT_GT(c.run_to_rest(40), 0);
  c.detector.reset();
  c.imu->clear();
  EXPECT_FALSE(c.detector.at_rest());
  EXPECT_FALSE(c.still()) << "no window of samples yet";
}

}  // namespace
}  // namespace pirvs
