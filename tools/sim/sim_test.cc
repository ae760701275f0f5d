#include "tools/sim/sim.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/player.h"
#include "tools/sim/motion.h"
#include "tools/sim/render.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

class Folder {
 public:
  explicit Folder(const std::string& name)
      : path_((fs::temp_directory_path() / ("pirvs_sim_" + std::to_string(getpid()) + name))
                  .string()) {}
  ~Folder() { fs::remove_all(path_); }
  const std::string& path() const { return path_; }
  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> out;
    for (const auto& entry : fs::recursive_directory_iterator(path_)) {
      if (!entry.is_regular_file()) continue;
      std::ostringstream text;
      text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
      out[fs::relative(entry.path(), path_).string()] = text.str();
    }
    return out;
  }

 private:
  std::string path_;
};

SimOptions short_run(const std::string& out) {
  SimOptions options;
  options.out = out;
  options.duration_s = 0.25;
  options.rest_s = 0;
  options.boxes = 10;
  options.blur = 2;
  return options;
}

TEST(sim, same_seed_same_bytes_whatever_the_threads) {
  const Folder one("a");
  const Folder two("b");
  const Folder other("c");
  SimOptions options = short_run(one.path());
  options.threads = 1;
  simulate(options, [](size_t, size_t) {});
  options.out = two.path();
  options.threads = 2;
  simulate(options, [](size_t, size_t) {});
  options.out = other.path();
  options.seed = 2;
  simulate(options, [](size_t, size_t) {});
  const auto files = one.files();
  EXPECT_EQ(files.size(), 7u + 2 * 3);
  EXPECT_TRUE(files == two.files());
  EXPECT_FALSE(files == other.files());
}

TEST(sim, its_recording_can_be_opened) {
  for (const char* device : {"euroc", "ironsides", "tumvi", "t265", "oakd"}) {
    const Folder folder(device);
    SimOptions options = short_run(folder.path());
    options.device = device;
    options.rate_hz = 20;
    simulate(options, [](size_t, size_t) {});
    const Recording recording = open_recording(folder.path(), {});
    EXPECT_TRUE(recording.rejected.empty());
    EXPECT_TRUE(recording.truth.full_state);
    EXPECT_EQ(recording.frames.size(), 3u);
    const Calibration& expected = find_device(device)->calibration;
    for (int c = 0; c < 2; ++c) {
      const Camera& camera = recording.calibration.camera[c];
      EXPECT_EQ(camera.model, expected.camera[c].model);
      EXPECT_NEAR(camera.fx, expected.camera[c].fx, 1e-6);
      EXPECT_LT((camera.T_BC.R - expected.camera[c].T_BC.R).norm(), 1e-9);
      EXPECT_LT((camera.T_BC.p - expected.camera[c].T_BC.p).norm(), 1e-9);
    }
    Player player(recording);
    const StereoFrame* const frame = player.next();
    ASSERT_NE(frame, nullptr);
    EXPECT_EQ(frame->present, 3);
  }
}

TEST(sim, says_what_is_wrong) {
  const Folder folder("d");
  SimOptions options = short_run(folder.path());
  options.device = "nikon";
  EXPECT_THROW(simulate(options, [](size_t, size_t) {}), InputError);
  options = short_run("/proc/no/such");
  EXPECT_THROW(simulate(options, [](size_t, size_t) {}), InputError);
}

TEST(sim, starts_at_rest) {
  const Path path = Path::flight(1, 1.0, 5, Mat3::Identity());
  for (const double t_s : {0.0, 0.5, 1.0}) {
    EXPECT_LT(path.at(t_s).v_WB.norm(), 1e-3);
    EXPECT_LT(path.at(t_s).w_B.norm(), 1e-3);
  }
  EXPECT_GT(path.at(4.5).v_WB.norm(), 0.3);
}

TEST(sim, a_steady_path_rests_and_then_keeps_its_velocity_and_turn) {
  const Device& device = *find_device("euroc");
  SteadyMotion motion;
  motion.rest_s = 1;
  motion.ramp_s = 1.5;
  motion.v_L = Vec3(0.2, -0.1, 0);
  motion.turn_rad_s = 0.03;
  const Path path = Path::steady(motion, 6, device.R_LB);
  for (const double t_s : {0.0, 0.5, 1.0}) {
    EXPECT_LT(path.at(t_s).v_WB.norm(), 1e-6);
    EXPECT_LT(path.at(t_s).w_B.norm(), 1e-6);
  }
  for (const double t_s : {3.2, 4.0, 5.9}) {
    const PathState state = path.at(t_s);
    EXPECT_LT((state.v_WB - motion.v_L).norm(), 1e-6) << "the look frame is W's at the start";
    EXPECT_LT((state.R_WB * state.w_B - Vec3(0, 0, motion.turn_rad_s)).norm(), 1e-6);
    EXPECT_LT(state.a_WB.norm(), 1e-6);
  }
  EXPECT_NEAR(path.at(1.9).v_WB.norm(), 0.5 * motion.v_L.norm(), 0.3 * motion.v_L.norm());
  motion.rest_s = 0;
  EXPECT_LT((Path::steady(motion, 6, device.R_LB).at(0).v_WB - motion.v_L).norm(), 1e-6);
}

// The share of pixels that differ between two instants, seen from one place.
double changed_share(const SimOptions& options, int frame_a, int frame_b) {
  Recording recording = open_recording(options.out, {});
  const auto file = [&](int frame) {
    std::ifstream in(recording.frames[size_t(frame)].image[0], std::ios::binary);
    std::ostringstream bytes;
    bytes << in.rdbuf();
    return bytes.str();
  };
  const std::string a = file(frame_a);
  const std::string b = file(frame_b);
  EXPECT_EQ(a.size(), b.size());
  size_t changed = 0;
  for (size_t i = 0; i < a.size(); ++i) changed += a[i] != b[i] ? 1 : 0;
  return double(changed) / double(a.size());
}

TEST(sim, a_mover_sways_before_a_device_at_rest) {
  const Folder folder("mover");
  SimOptions options = short_run(folder.path());
  options.path = "rest";
  options.format = "pgm";
  options.duration_s = 2.9;
  options.rate_hz = 2;
  options.image_noise = 0;
  options.mover = 0.4;
  options.mover_from_s = 1.1;
  simulate(options, [](size_t, size_t) {});  // frames at 0.1, 0.6, 1.1, 1.6, 2.1, 2.6 s
  EXPECT_EQ(changed_share(options, 0, 2), 0) << "nothing moves before it comes in";
  const double at_once = changed_share(options, 2, 5);
  EXPECT_GT(at_once, 0.25);
  EXPECT_LT(at_once, 0.6);
}

// From one place only what moved is drawn anew: it must be what drawing all of it gives.
TEST(sim, drawing_on_gives_what_drawing_anew_gives) {
  const Device& device = *find_device("euroc");
  const Path path = Path::flight(4, 9, 8, device.R_LB);
  Pillar pillar;
  pillar.width_m = 0.8;
  pillar.sway_m = 0.6;
  const Vec3 ahead_W = path.at(0).R_WB * (device.calibration.camera[0].T_BC.R * Vec3::UnitZ());
  pillar.p_W = path.at(0).p_WB + 1.5 * ahead_W;
  SceneOptions options;
  options.seed = 4;
  options.boxes = 12;
  options.movers = 4;
  options.pillar = pillar;
  const Scene scene(path, options);
  Renderer on(device.calibration.camera[0], scene, path);
  std::vector<uint8_t> drawn_on, anew;
  Exposure exposure;
  for (const double t_s : {1.0, 1.05, 1.6}) {
    exposure.t_s = t_s;
    on.render(exposure, drawn_on);
  }
  Renderer(device.calibration.camera[0], scene, path).render(exposure, anew);
  EXPECT_TRUE(drawn_on == anew);
}

TEST(sim, a_room_is_the_same_for_every_flight_but_for_what_is_gone) {
  const Mat3& R_LB = find_device("euroc")->R_LB;
  const Path monday = Path::flight(1, 0.5, 30, R_LB), tuesday = Path::flight(2, 0.5, 30, R_LB);
  SceneOptions options;
  options.room = true;
  options.seed = 7;
  options.boxes = 50;
  std::vector<Box> before, after;
  Scene(monday, options).boxes_at(0, before);
  options.visit = 2;
  options.gone = 0.3;
  options.movers = 3;
  Scene(tuesday, options).boxes_at(0, after);
  ASSERT_EQ(before.size(), 51u) << "the hall, and what stands in it";
  ASSERT_EQ(after.size(), 54u);
  int same = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    same += std::memcmp(&before[i], &after[i], sizeof(Box)) == 0 ? 1 : 0;
  }
  EXPECT_EQ(same, 36) << "15 of 50 are gone";
  for (const Path* path : {&monday, &tuesday}) {
    for (double t_s = 0; t_s < 30; t_s += 0.1) {
      const Vec3 p = path->at(t_s).p_WB;
      ASSERT_TRUE((p - kFlightLo).minCoeff() > 0 && (kFlightHi - p).minCoeff() > 0) << t_s;
    }
  }
}

TEST(sim, path_derivatives_match_numeric) {
  const Path path = Path::flight(3, 0.5, 10, find_device("euroc")->R_LB);
  constexpr double kStep_s = 1e-4;
  for (double t_s = 0.1; t_s < 9.9; t_s += 0.37) {
    const PathState a = path.at(t_s - kStep_s);
    const PathState b = path.at(t_s + kStep_s);
    const PathState at = path.at(t_s);
    EXPECT_LT(((b.p_WB - a.p_WB) / (2 * kStep_s) - at.v_WB).norm(), 1e-6);
    EXPECT_LT(((b.v_WB - a.v_WB) / (2 * kStep_s) - at.a_WB).norm(), 1e-5);
    const Vec3 turn_B = so3_log(a.R_WB.transpose() * b.R_WB) / (2 * kStep_s);
    EXPECT_LT((turn_B - at.w_B).norm(), 1e-6);
    EXPECT_LT((rotation_from_quat_xyzw(at.q_WB) - at.R_WB).norm(), 1e-12);
  }
}

TEST(sim, imu_integrates_back_to_the_truth) {
  const Path path = Path::flight(5, 1, 10, Mat3::Identity());
  ImuModel model{find_device("euroc")->calibration.imu, 0.02, 0.05};
  model.noise.gyro_noise = model.noise.accel_noise = 0;
  const auto imu = simulate_imu(path, model, 0, 5);
  Mat3 R_WB = imu[0].truth.R_WB;
  Vec3 v_WB = imu[0].truth.v_WB;
  Vec3 p_WB = imu[0].truth.p_WB;
  const Vec3 g_W(0, 0, -kGravity_m_s2);
  for (size_t i = 1; i < imu.size(); ++i) {
    const double dt_s = to_seconds(imu[i].sample.t - imu[i - 1].sample.t);
    const Vec3 w0_B = imu[i - 1].sample.w_B - imu[i - 1].b_g;
    const Vec3 w1_B = imu[i].sample.w_B - imu[i].b_g;
    const Mat3 R1_WB = R_WB * so3_exp((w0_B + w1_B) / 2 * dt_s);
    const Vec3 a0_W = R_WB * (imu[i - 1].sample.f_B - imu[i - 1].b_a) + g_W;
    const Vec3 a1_W = R1_WB * (imu[i].sample.f_B - imu[i].b_a) + g_W;
    p_WB += v_WB * dt_s + (2 * a0_W + a1_W) / 6 * dt_s * dt_s;
    v_WB += (a0_W + a1_W) / 2 * dt_s;
    R_WB = R1_WB;
  }
  EXPECT_LT((p_WB - imu.back().truth.p_WB).norm(), 2e-3);  // trapezoids over 10 s
  EXPECT_LT((v_WB - imu.back().truth.v_WB).norm(), 1e-3);
  EXPECT_LT(so3_log(R_WB.transpose() * imu.back().truth.R_WB).norm(), 1e-4);
}

TEST(sim, imu_noise_has_the_density_asked_for) {
  const Path path = Path::flight(5, 1000, 50, Mat3::Identity());  // at rest
  ImuModel model{{1e-3, 0, 2e-2, 0, 200}, 0.02, 0.05};
  const auto imu = simulate_imu(path, model, 0, 5);
  double gyro = 0;
  double accel = 0;
  for (const SimulatedImu& i : imu) {
    gyro += (i.sample.w_B - i.b_g).squaredNorm() / 3;
    accel += (i.sample.f_B - i.b_a - i.truth.R_WB.transpose() * Vec3(0, 0, kGravity_m_s2))
                 .squaredNorm() /
             3;
  }
  const double root_rate = std::sqrt(200.0);
  EXPECT_NEAR(std::sqrt(gyro / double(imu.size())), 1e-3 * root_rate, 2e-4);
  EXPECT_NEAR(std::sqrt(accel / double(imu.size())), 2e-2 * root_rate, 4e-3);
}

// The largest of a quantity of the path from one instant to another.
template <class Quantity>
double largest(const Path& path, double from_s, double to_s, const Quantity& quantity) {
  double out = 0;
  for (double t_s = from_s; t_s < to_s; t_s += 0.01) out = std::max(out, quantity(path.at(t_s)));
  return out;
}

TEST(sim, every_motion_rests_at_first_and_is_drawn_by_its_seed) {
  for (const char* name : {"hover", "loop", "handheld", "vehicle"}) {
    Motion motion = Motion::kHover;
    ASSERT_TRUE(find_motion(name, motion));
    const Path path = make_motion(motion, 3, 1, 10, Mat3::Identity());
    const auto speed = [](const PathState& s) { return s.v_WB.norm() + s.w_B.norm(); };
    EXPECT_LT(largest(path, 0, 1, speed), 1e-6) << name;
    EXPECT_GT(largest(path, 2, 10, speed), 0.1) << name;
    EXPECT_LT(largest(path, 0, 10, [](const PathState& s) { return s.a_WB.norm(); }), 6) << name;
    const Path same = make_motion(motion, 3, 1, 10, Mat3::Identity());
    const Path other = make_motion(motion, 4, 1, 10, Mat3::Identity());
    EXPECT_EQ((path.at(7).p_WB - same.at(7).p_WB).norm(), 0) << name;
    EXPECT_GT((path.at(7).p_WB - other.at(7).p_WB).norm(), 0.01) << name;
  }
  Motion motion = Motion::kHover;
  EXPECT_FALSE(find_motion("swim", motion));
}

TEST(sim, a_hover_stays_and_a_loop_comes_back) {
  const Path hover = make_motion(Motion::kHover, 1, 1, 30, Mat3::Identity());
  const Vec3 above_W = hover.at(5).p_WB;
  EXPECT_LT(largest(hover, 5, 30, [&](const PathState& s) { return (s.p_WB - above_W).norm(); }),
            0.5);
  const Path loop = make_motion(Motion::kLoop, 1, 1, 30, Mat3::Identity());
  const PathState first = loop.at(6);
  double nearest_m = 1e9;
  double turned_rad = 0;
  for (double t_s = 16; t_s < 22; t_s += 0.02) {
    const PathState again = loop.at(t_s);
    const double distance_m = (again.p_WB - first.p_WB).norm();
    if (distance_m > nearest_m) continue;
    nearest_m = distance_m;
    turned_rad = so3_log(first.R_WB.transpose() * again.R_WB).norm();
  }
  EXPECT_LT(nearest_m, 0.05);
  EXPECT_LT(turned_rad, 0.5);
  EXPECT_GT(largest(loop, 6, 19, [&](const PathState& s) { return (s.p_WB - first.p_WB).norm(); }),
            4);
}

TEST(sim, a_vehicle_goes_ahead_alone_and_stops_and_hands_shake) {
  const Path vehicle = make_motion(Motion::kVehicle, 1, 1, 30, Mat3::Identity());
  const auto aside = [](const PathState& s) { return std::abs((s.R_WB.transpose() * s.v_WB).y()); };
  EXPECT_LT(largest(vehicle, 0, 30, aside), 0.05);
  EXPECT_GT(largest(vehicle, 0, 30, [](const PathState& s) { return s.v_WB.norm(); }), 2.4);
  EXPECT_LT(vehicle.at(1 + 13.6).v_WB.norm(), 0.02);
  const Path carried = make_motion(Motion::kHandheld, 1, 1, 30, Mat3::Identity());
  const double turn_rad_s =
      largest(carried, 2, 30, [](const PathState& s) { return s.w_B.norm(); });
  EXPECT_GT(turn_rad_s, 0.5);
  EXPECT_LT(turn_rad_s, 3);
}

TEST(sim, a_recorded_path_is_followed_closely) {
  Trajectory recorded;
  const Path original = Path::flight(9, 0, 6, Mat3::Identity());
  for (double t_s = 0; t_s < 6; t_s += 0.05) {
    TrajectoryPose pose;
    pose.t = from_seconds(t_s);
    pose.t_s = t_s;
    const PathState state = original.at(t_s);
    pose.p_WB = state.p_WB;
    pose.q_WB = state.q_WB;
    recorded.poses.push_back(pose);
  }
  const Path path = Path::along(recorded, 0);
  for (double t_s = 0.5; t_s < 5.5; t_s += 0.11) {
    EXPECT_LT((path.at(t_s).p_WB - original.at(t_s).p_WB).norm(), 0.02);
    EXPECT_LT(so3_log(path.at(t_s).R_WB.transpose() * original.at(t_s).R_WB).norm(), 0.02);
  }
}

float grey_at(const std::vector<uint8_t>& image, int width, const Vec2& uv) {
  const int x = int(uv.x());
  const int y = int(uv.y());
  const float ax = float(uv.x()) - float(x);
  const float ay = float(uv.y()) - float(y);
  const uint8_t* const p = image.data() + size_t(y) * size_t(width) + size_t(x);
  return (p[0] * (1 - ax) + p[1] * ax) * (1 - ay) + (p[width] * (1 - ax) + p[width + 1] * ax) * ay;
}

// A surface point found by a ray of the left camera's model, drawn by the right one's a moment
// later: where that camera's model says, it must look the same; a few pixels beside, it does not.
TEST(sim, a_rendered_point_lies_where_the_camera_model_says) {
  for (const char* name : {"euroc", "ironsides"}) {
    const Device& device = *find_device(name);
    const Path path = Path::flight(4, 0, 8, device.R_LB);
    SceneOptions options;
    options.seed = 4;
    options.boxes = 12;
    const Scene scene(path, options);
    const Camera* const camera = device.calibration.camera;
    const double t_s[2] = {5.0, 5.1};
    std::vector<uint8_t> image[2];
    for (int c = 0; c < 2; ++c) {
      Exposure exposure;
      exposure.t_s = t_s[c];
      exposure.gain = 1.5;
      Renderer(camera[c], scene, path).render(exposure, image[c]);
    }
    std::vector<Box> boxes;
    scene.boxes_at(0, boxes);
    std::vector<int> all(boxes.size() - 1);
    for (size_t i = 0; i < all.size(); ++i) all[i] = int(i) + 1;
    SE3 T_WC[2];
    for (int c = 0; c < 2; ++c) {
      const PathState state = path.at(t_s[c]);
      T_WC[c] = SE3{state.R_WB, state.p_WB} * camera[c].T_BC;
    }
    std::vector<double> at_model;
    std::vector<double> beside;
    const auto cast = [&](const Vec3& o_W, const Vec3& d_W) {
      const Ray3 o = {float(o_W.x()), float(o_W.y()), float(o_W.z())};
      const Ray3 d = {float(d_W.x()), float(d_W.y()), float(d_W.z())};
      return Scene::cast(boxes.data(), all.data(), int(all.size()), o, d);
    };
    for (int y = 20; y < camera[0].height - 20; y += 7) {
      for (int x = 20; x < camera[0].width - 20; x += 7) {
        Vec3 bearing_C;
        if (!camera[0].unproject(Vec2(x, y), bearing_C)) continue;
        const Vec3 d_W = T_WC[0].R * bearing_C;
        const Vec3 p_W = T_WC[0].p + d_W * double(cast(T_WC[0].p, d_W).distance);
        const Vec3 p_C1 = T_WC[1].inverse() * p_W;
        Vec2 uv;
        if (!camera[1].project(p_C1, uv) || !camera[1].in_image(uv, 12)) continue;
        const Vec3 back_W = (p_W - T_WC[1].p).normalized();
        if (double(cast(T_WC[1].p, back_W).distance) < p_C1.norm() - 0.01) continue;  // hidden
        // Vignetting differs between the two places; the texture's own brightness does not.
        Vec3 bearing_C1;
        if (!camera[1].unproject(uv, bearing_C1)) continue;
        const double fall = (0.45 + 0.55 * bearing_C.z()) / (0.45 + 0.55 * bearing_C1.z());
        const double grey = image[0][size_t(y * camera[0].width + x)];
        const auto difference = [&](const Vec2& at) {
          return std::abs(grey - fall * double(grey_at(image[1], camera[1].width, at)));
        };
        at_model.push_back(difference(uv));
        beside.push_back(difference(uv + Vec2(5, 4)));
      }
    }
    ASSERT_GT(at_model.size(), 500u) << name;
    const auto median = [](std::vector<double> v) {
      std::nth_element(v.begin(), v.begin() + long(v.size() / 2), v.end());
      return v[v.size() / 2];
    };
    EXPECT_LT(median(at_model), 2.5) << name;
    EXPECT_GT(median(beside), 2.5 * median(at_model)) << name;
  }
}

}  // namespace
}  // namespace pirvs::tools
