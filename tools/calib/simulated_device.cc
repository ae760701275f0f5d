#include "tools/calib/simulated_device.h"

#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "tools/calib/tag_image.h"

namespace pirvs::tools {
namespace {

constexpr TimeNs kStart = 1'600'000'000'000'000'000;
constexpr double kBefore_s = 0.2;  // of samples, before and after images
constexpr double kSettle_s = 1;    // from rest to motion and back
constexpr double kDistance_m = 0.6;
const Vec3 kUp_T = Vec3(0.03, 0.99, -0.13).normalized();  // the board hangs on a wall, nearly

struct Wave {
  double amplitude, hz;
};
// Angles about the camera's axes, places along the board's.
constexpr Wave kWaves[6][3] = {
    {{0.45, 0.23}, {0.15, 0.71}, {0.05, 1.9}}, {{0.55, 0.19}, {0.15, 0.63}, {0.05, 1.7}},
    {{0.9, 0.13}, {0.25, 0.83}, {0.05, 1.5}},  {{0.22, 0.17}, {0.06, 0.77}, {0.02, 1.6}},
    {{0.18, 0.27}, {0.06, 0.67}, {0.02, 1.8}}, {{0.2, 0.11}, {0.06, 0.73}, {0.02, 1.4}},
};

double length_s(const SimulatedRecording& how) { return how.duration_s + 2 * how.rest_s; }

// 0 at rest, 1 in motion, with its first and second derivatives; 10 u^3 - 15 u^4 + 6 u^5 between.
Vec3 swing(const SimulatedRecording& how, double t_s) {
  if (how.rest_s <= 0) return {1, 0, 0};
  const double from_s = t_s - kBefore_s - how.rest_s;
  const double to_s = kBefore_s + length_s(how) - how.rest_s - t_s;
  const double sign = from_s < to_s ? 1 : -1;
  const double u = std::min(from_s, to_s) / kSettle_s;
  if (u <= 0) return Vec3::Zero();
  if (u >= 1) return {1, 0, 0};
  return {u * u * u * (10 + u * (6 * u - 15)), sign * 30 * u * u * (1 - u) * (1 - u) / kSettle_s,
          60 * u * (1 - u) * (1 - 2 * u) / (kSettle_s * kSettle_s)};
}

}  // namespace

CameraRig SimulatedDevice::nominal_rig() {
  CameraRig out;
  out.cameras = 2;
  for (int c = 0; c < 2; ++c) {
    out.camera[c] = {CameraModel::kKannalaBrandt,
                     640,
                     480,
                     190.978,
                     190.973,
                     319.5,
                     239.5,
                     {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673},
                     {}};
    SE3& T_BC = out.camera[c].T_BC;  // B: x forward, y left, z up
    T_BC.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    T_BC.p = Vec3(0.02, c == 0 ? 0.0325 : -0.0325, 0.01);
  }
  out.T_C1C0 = out.camera[1].T_BC.inverse() * out.camera[0].T_BC;
  return out;
}

SimulatedDevice::SimulatedDevice(uint64_t seed) : rig(nominal_rig()), random_(seed, 1) {
  for (Camera& camera : rig.camera) {
    camera.fx *= 1 + uniform(0.01);
    camera.fy = camera.fx * (1 + uniform(0.0005));
    camera.cx += uniform(5), camera.cy += uniform(5);
    for (double& d : camera.d) d += uniform(0.002);
    camera.T_BC.R = camera.T_BC.R * so3_exp(M_PI / 180 * vec(1));
    camera.T_BC.p += 0.003 * vec(1);
  }
  rig.T_C1C0 = rig.camera[1].T_BC.inverse() * rig.camera[0].T_BC;
  offset_s = kNominalOffset_s + uniform(0.002);
  constexpr double kScale = 0.01, kTurned = 0.5 * M_PI / 180;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      imu.gyro(i, j) += uniform(i == j ? kScale : kTurned);
      if (j <= i) imu.accel(i, j) += uniform(i == j ? kScale : kTurned);
    }
  }
  imu.b_g = vec(0.02), imu.b_a = vec(0.2);
  noise.gyro_noise = 1.7e-4, noise.accel_noise = 2e-3;
  noise.gyro_walk = 2e-5, noise.accel_walk = 3e-4;
  noise.rate_hz = 200;
  for (double& phase : phase_) phase = random_.uniform(0, 2 * M_PI);
  board = target;
  for (int tag = 0; tag < target.tags(); ++tag) {
    board.shift_T.push_back(tag_prior_m(target).cwiseProduct(normal()));
  }
}

std::vector<TimeNs> SimulatedDevice::stamps(const SimulatedRecording& how) const {
  std::vector<TimeNs> out;
  for (int n = 0; n < int(length_s(how) * how.frames_hz); ++n) {
    out.push_back(kStart + from_seconds(kBefore_s + n / how.frames_hz - offset_s));
  }
  return out;
}

std::vector<Shot> SimulatedDevice::shots(const SimulatedRecording& how) {
  std::vector<Shot> out;
  for (const TimeNs t : stamps(how)) {
    const SE3 T_C0T = pose(how, t);
    Shot shot;
    shot.t = t;
    for (int c = 0; c < 2; ++c) {
      shot.view[c].t = t;
      see(how, rig.camera[c], c == 0 ? T_C0T : rig.T_C1C0 * T_C0T, shot.view[c]);
    }
    out.push_back(shot);
  }
  return out;
}

SE3 SimulatedDevice::pose(const SimulatedRecording& how, TimeNs t) const {
  const double t_s = to_seconds(t - kStart) + offset_s;
  return (motion(how, t_s).T_TB * rig.camera[0].T_BC).inverse();
}

std::vector<ImuSample> SimulatedDevice::samples(const SimulatedRecording& how) {
  const double root = std::sqrt(how.imu_hz);
  std::vector<ImuSample> out;
  for (int n = 0; n < int((length_s(how) + 2 * kBefore_s) * how.imu_hz); ++n) {
    const Motion at = motion(how, n / how.imu_hz);
    const Vec3 f_B = at.T_TB.R.transpose() * (at.a_T + kGravity_m_s2 * kUp_T);
    ImuSample sample;
    sample.t = kStart + from_seconds(n / how.imu_hz);
    sample.w_B = imu.gyro * at.w_B + imu.b_g + noise.gyro_noise * root * normal();
    sample.f_B = imu.accel * f_B + imu.b_a + noise.accel_noise * root * normal();
    out.push_back(sample);
  }
  return out;
}

Vec3 SimulatedDevice::vec(double a) {
  const double x = uniform(a), y = uniform(a), z = uniform(a);
  return {x, y, z};
}

Vec3 SimulatedDevice::normal() {
  const double x = random_.normal(), y = random_.normal(), z = random_.normal();
  return {x, y, z};
}

// Value, first and second derivative of axis k: 0..2 angles, 3..5 places.
Vec3 SimulatedDevice::wave(const SimulatedRecording& how, int k, double t_s) const {
  const double share = k == 2 ? how.roll * how.turning : k < 3 ? how.turning : how.moving;
  Vec3 out = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double w = 2 * M_PI * kWaves[k][i].hz, a = share * kWaves[k][i].amplitude;
    const double angle = w * t_s + phase_[3 * k + i];
    out += a * Vec3(std::sin(angle), w * std::cos(angle), -w * w * std::sin(angle));
  }
  const Vec3 s = swing(how, t_s);
  return {s[0] * out[0], s[1] * out[0] + s[0] * out[1],
          s[2] * out[0] + 2 * s[1] * out[1] + s[0] * out[2]};
}

SimulatedDevice::Motion SimulatedDevice::motion(const SimulatedRecording& how, double t_s) const {
  Vec3 phi, phi_dot, p, a;
  for (int k = 0; k < 3; ++k) {
    const Vec3 angle = wave(how, k, t_s), place = wave(how, 3 + k, t_s);
    phi[k] = angle[0], phi_dot[k] = angle[1];
    p[k] = place[0], a[k] = place[2];
  }
  Mat3 R_TC, R_CB;  // facing the board; the nominal camera in B
  R_TC << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  R_CB << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  Motion out;
  out.T_TB.R = R_TC * so3_exp(phi) * R_CB;
  out.T_TB.p = target.middle_T() + Vec3(0, 0, kDistance_m) + p;
  out.w_B = R_CB.transpose() * right_jacobian(phi) * phi_dot;
  out.a_T = a;
  return out;
}

void SimulatedDevice::see(const SimulatedRecording& how, const Camera& camera, const SE3& T_CT,
                          View& out) {
  constexpr double kRim_px = 12;  // a tag nearer to it is cut off
  for (int tag = 0; tag < target.tags(); ++tag) {
    TagImage image;
    if (!project_tag(camera, board, T_CT, tag, image)) continue;
    const double x = random_.normal(), y = random_.normal();
    const Vec2 uv = image.uv + how.tag_px * Vec2(x, y);
    if (camera.in_image(uv, kRim_px)) out.tags.push_back({tag, uv});
  }
}

}  // namespace pirvs::tools
