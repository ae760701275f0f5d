// What the tests of all modules share: seeded random states, a stereo rig, a texture, a motion.
// Frames  B of the rig: x forward, y left, z up; both cameras look along x, 0.11 m apart.
// Units   SI, px. Source: EuRoC's lenses (radtan), the device's fisheyes (Kannala-Brandt).
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "modules/imu/imu_sample.h"
#include "modules/map/map.h"

namespace pirvs::testing {

struct Random {
  explicit Random(uint32_t seed) : engine(seed) {}
  double uniform(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(engine);
  }
  double gauss(double sigma) { return sigma * normal(engine); }
  Vec3 vec(double sigma) {
    const double x = gauss(sigma), y = gauss(sigma), z = gauss(sigma);
    return {x, y, z};
  }
  Vec2 pixel(double sigma) {
    const double x = gauss(sigma), y = gauss(sigma);
    return {x, y};
  }
  Vec15 vec15(double sigma) {
    Vec15 out;
    for (int i = 0; i < 15; ++i) out[i] = gauss(sigma);
    return out;
  }
  BodyState state() {
    BodyState s;
    s.T_WB.R = so3_exp(vec(1.0));
    s.T_WB.p = vec(3.0);
    s.v_WB = vec(1.0);
    s.b_g = vec(0.05);
    s.b_a = vec(0.2);
    return s;
  }
  // Symmetric positive definite, eigenvalues around scale.
  template <int N>
  Eigen::Matrix<double, N, N> spd(double scale) {
    Eigen::Matrix<double, N, N> A;
    for (int i = 0; i < N * N; ++i) A.data()[i] = gauss(1.0);
    return scale * (A * A.transpose() / N + 0.1 * Eigen::Matrix<double, N, N>::Identity());
  }
  std::mt19937 engine;
  std::normal_distribution<double> normal;
};

inline Camera lens(CameraModel model) {
  Camera camera;
  camera.model = model;
  camera.width = model == CameraModel::kPinholeRadtan ? 752 : 640;
  camera.height = 480;
  const bool radtan = model == CameraModel::kPinholeRadtan;
  const double intrinsics[4] = {radtan ? 458.654 : 190.978, radtan ? 457.296 : 190.973,
                                radtan ? 367.215 : 319.5, radtan ? 248.375 : 239.5};
  const double radtan_d[4] = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05};
  const double fisheye_d[4] = {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673};
  camera.fx = intrinsics[0], camera.fy = intrinsics[1];
  camera.cx = intrinsics[2], camera.cy = intrinsics[3];
  std::copy(radtan ? radtan_d : fisheye_d, (radtan ? radtan_d : fisheye_d) + 4, camera.d);
  return camera;
}

struct Rig {
  explicit Rig(CameraModel model) {
    for (int c = 0; c < kCamerasMax; ++c) {
      camera[c] = lens(model);
      camera[c].T_BC.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
      camera[c].T_BC.R = camera[c].T_BC.R * so3_exp(Vec3(0.01, c == 0 ? 0.005 : -0.008, 0.006));
      camera[c].T_BC.p = Vec3(0.03, c == 0 ? 0.055 : -0.055, 0.01);
    }
  }
  // The same lenses on sensors of half the resolution: faster to render.
  void halve() {
    for (Camera& c : camera) {
      c.width /= 2, c.height /= 2;
      c.fx /= 2, c.fy /= 2;
      c.cx = (c.cx - 0.5) / 2, c.cy = (c.cy - 0.5) / 2;
    }
  }
  // False: not in front of the camera, or outside its image.
  bool see(const SE3& T_WB, int c, const Vec3& p_W, Vec2& uv) const {
    return camera[c].project((T_WB * camera[c].T_BC).inverse() * p_W, uv) &&
           camera[c].in_image(uv, 0);
  }
  Camera camera[kCamerasMax];
};

// Smooth grey noise over the plane, detail of 1/2 to 2 units, the same for the same seed.
struct Texture {
  explicit Texture(uint32_t texture_seed) : seed(texture_seed) {}
  double lattice(int x, int y, uint32_t octave) const {
    uint32_t h = seed + 0x9e3779b9u * octave;
    for (const uint32_t v : {static_cast<uint32_t>(x), static_cast<uint32_t>(y)}) {
      h = (h ^ v) * 0x85ebca6bu;
      h ^= h >> 13;
      h *= 0xc2b2ae35u;
      h ^= h >> 16;
    }
    return h / 4294967296.0;
  }
  double at(double x, double y) const {
    double sum = 0;
    for (uint32_t octave = 0; octave < 3; ++octave) {
      const double scale = 2.0 / (1 << octave);
      const double u = x * scale, v = y * scale;
      const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
      const double a = smooth(u - i), b = smooth(v - j);
      const double top = (1 - a) * lattice(i, j, octave) + a * lattice(i + 1, j, octave);
      const double low = (1 - a) * lattice(i, j + 1, octave) + a * lattice(i + 1, j + 1, octave);
      sum += (1 - b) * top + b * low;
    }
    return 30 + 65 * sum;  // 30 .. 225
  }
  static double smooth(double t) { return t * t * t * (t * (6 * t - 15) + 10); }
  uint32_t seed;
};

// A body that sways: analytic pose, velocity and what a perfect IMU feels.
struct Sway {
  Vec3 amplitude_m = Vec3(0.4, 0.5, 0.25), omega_rad_s = Vec3(2.0, 1.5, 2.6);
  Vec3 angle_rad = Vec3(0.12, 0.1, 0.2), omega_angle_rad_s = Vec3(1.8, 2.2, 1.4);
  Vec3 b_g = Vec3::Zero(), b_a = Vec3::Zero();

  static Vec3 sines(const Vec3& amplitude, const Vec3& omega, double t, int derivative) {
    Vec3 out;
    for (int k = 0; k < 3; ++k) {
      const double phase = omega[k] * t + 0.7 * k + derivative * M_PI / 2;
      out[k] = amplitude[k] * std::pow(omega[k], derivative) * std::sin(phase);
    }
    return out;
  }
  BodyState state(double t_s) const {
    BodyState s;
    s.t = from_seconds(t_s);
    s.T_WB.R = so3_exp(sines(angle_rad, omega_angle_rad_s, t_s, 0));
    s.T_WB.p = sines(amplitude_m, omega_rad_s, t_s, 0);
    s.v_WB = sines(amplitude_m, omega_rad_s, t_s, 1);
    s.b_g = b_g;
    s.b_a = b_a;
    return s;
  }
  ImuSample imu(double t_s) const {
    const Vec3 phi = sines(angle_rad, omega_angle_rad_s, t_s, 0);
    const Vec3 a_W = sines(amplitude_m, omega_rad_s, t_s, 2);
    ImuSample sample;
    sample.t = from_seconds(t_s);
    sample.w_B = right_jacobian(phi) * sines(angle_rad, omega_angle_rad_s, t_s, 1) + b_g;
    sample.f_B = so3_exp(phi).transpose() * (a_W + Vec3(0, 0, kGravity_m_s2)) + b_a;
    return sample;
  }
  Preintegration between(double t0_s, double t1_s, const ImuNoise& noise) const {
    Preintegration motion;
    motion.reset(b_g, b_a);
    const int steps = static_cast<int>(std::lround((t1_s - t0_s) * noise.rate_hz));
    const double dt_s = (t1_s - t0_s) / steps;
    for (int i = 0; i < steps; ++i) {
      const ImuSample a = imu(t0_s + i * dt_s), b = imu(t0_s + (i + 1) * dt_s);
      motion.add(a.w_B, a.f_B, b.w_B, b.f_B, dt_s, noise);
    }
    return motion;
  }
};

}  // namespace pirvs::testing
