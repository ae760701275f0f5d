#include "tools/calib/motion_start.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "tools/calib/board_scale.h"
#include "tools/dataset/gyro_integral.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr double kStep_s_max = 0.15;  // between images, for a turn rate
constexpr double kTurning_rad_s = 0.2;

struct Turn {
  TimeNs from, to;
  Vec3 w_C;
};

std::vector<Turn> camera_turns(const std::vector<PosedShot>& shots) {
  std::vector<Turn> out;
  for (size_t i = 1; i < shots.size(); ++i) {
    const TimeNs from = shots[i - 1].shot.t, to = shots[i].shot.t;
    const double dt_s = to_seconds(to - from);
    if (!(dt_s > 0 && dt_s < kStep_s_max)) continue;
    const Mat3 R_C0C1 = shots[i - 1].T_C0T.R * shots[i].T_C0T.R.transpose();
    out.push_back({from, to, so3_log(R_C0C1) / dt_s});
  }
  return out;
}

struct Fit {
  Mat3 R_BC = Mat3::Identity();
  Vec3 b_g = Vec3::Zero();
  double error = HUGE_VAL;  // rms, rad/s
  double ratio = 1;         // gyro over camera
  double speed_rad_s = 0;   // of the camera, rms
};

Fit fit(const std::vector<Turn>& turns, const GyroIntegral& gyro, TimeNs offset) {
  std::vector<Vec3> w_B, w_C;
  Vec3 mean_B = Vec3::Zero(), mean_C = Vec3::Zero();
  for (const Turn& turn : turns) {
    Vec3 w;
    if (!gyro.rate(turn.from + offset, turn.to + offset, w)) continue;
    w_B.push_back(w);
    w_C.push_back(turn.w_C);
    mean_B += w_B.back();
    mean_C += w_C.back();
  }
  Fit out;
  const double n = double(w_B.size());
  if (w_B.size() < 20) return out;
  mean_B /= n, mean_C /= n;
  Mat3 M = Mat3::Zero();
  double square_B = 0, square_C = 0;
  for (size_t i = 0; i < w_B.size(); ++i) {
    const Vec3 b = w_B[i] - mean_B, c = w_C[i] - mean_C;
    M += b * c.transpose();
    square_B += b.squaredNorm();
    square_C += c.squaredNorm();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 sign = Mat3::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  out.R_BC = svd.matrixU() * sign * svd.matrixV().transpose();
  out.ratio = std::sqrt(square_B / square_C);
  out.speed_rad_s = std::sqrt(square_C / n);
  out.b_g = mean_B - out.R_BC * mean_C;
  const double fitted = (out.R_BC * Mat3::Identity()).cwiseProduct(M).sum();
  // Of the best scale, too: units are asked about afterwards.
  out.error = std::sqrt(std::max(0.0, square_B - fitted * fitted / square_C) / n) / out.ratio;
  return out;
}

// The board's view of gravity: accelerations of a hand come to nothing over the recording.
Vec3 gravity(const std::vector<PosedShot>& shots, const std::vector<ImuSample>& imu,
             const MotionStart& start, double& f_m_s2) {
  Vec3 sum = Vec3::Zero();
  double norm = 0;
  size_t count = 0, i = 0;
  for (const PosedShot& shot : shots) {
    const TimeNs t = shot.shot.t + from_seconds(start.offset_s);
    while (i + 1 < imu.size() && imu[i].t < t) ++i;
    const Mat3 R_TB = (start.R_BC * shot.T_C0T.R).transpose();
    sum += R_TB * imu[i].f_B;
    norm += imu[i].f_B.norm();
    ++count;
  }
  f_m_s2 = norm / double(count);
  return -sum.normalized();
}

void check(const Fit& best, double f_m_s2) {
  const std::string where = "the IMU";
  constexpr double kDegrees = 180 / M_PI;
  if (best.speed_rad_s < kTurning_rad_s) {
    throw InputError("the recording hardly turns", where,
                     "turn the device about all three axes, briskly, back and forth");
  }
  if (std::abs(std::log(best.ratio / kDegrees)) < 0.3) {
    throw InputError("the gyro seems to be in degrees per second", where, "give rad/s");
  }
  if (best.error > 0.5 * best.speed_rad_s) {
    throw InputError("the gyro's turns are not those of the images", where,
                     "check that both are of one recording and that their clocks agree within " +
                         std::to_string(int(1e3 * kOffset_s_max)) + " ms");
  }
  if (std::abs(std::log(best.ratio)) > 0.15) {
    throw InputError("the gyro turns by another amount than the images", where,
                     "check its unit and scale: it needs rad/s");
  }
  if (std::abs(std::log(f_m_s2)) < 0.3) {
    throw InputError("the accelerometer seems to be in g", where, "give m/s^2");
  }
  if (std::abs(std::log(f_m_s2 / kGravity_m_s2)) > 0.3) {
    throw InputError("the accelerometer does not feel gravity", where,
                     "check its unit: it needs m/s^2, gravity included");
  }
}

void check_board_size(const std::vector<PosedShot>& shots, const std::vector<ImuSample>& imu,
                      const MotionStart& start) {
  constexpr double kOff_max = 0.04;
  double scale = 1, sigma = 0;
  if (!board_scale(shots, imu, start, scale, sigma)) return;
  if (std::abs(scale - 1) < std::max(kOff_max, 4 * sigma)) return;
  throw InputError("the board is " + std::to_string(int(std::lround(100 * scale))) +
                       " % of the size that its yaml says, by the accelerometer",
                   "the target", "measure a tag, edge to edge, and correct tagSize");
}

}  // namespace

MotionStart start_motion(const std::vector<PosedShot>& shots, const std::vector<ImuSample>& imu) {
  if (imu.size() < 100) throw InputError("too few samples", "the IMU", "record both together");
  const std::vector<Turn> turns = camera_turns(shots);
  const GyroIntegral gyro(imu);
  constexpr TimeNs kStep = 1'000'000;
  const TimeNs most = from_seconds(kOffset_s_max);
  Fit best;
  TimeNs at = 0;
  for (TimeNs offset = -most; offset <= most; offset += kStep) {
    const Fit next = fit(turns, gyro, offset);
    if (next.error < best.error) best = next, at = offset;
  }
  if (!std::isfinite(best.error)) {
    throw InputError("images and IMU samples are not of one time", "the IMU",
                     "check that their stamps are of one clock, within " +
                         std::to_string(int(1e3 * kOffset_s_max)) + " ms");
  }
  if (std::abs(at) > most - 5 * kStep) {
    throw InputError(
        "the clocks of camera and IMU are too far apart", "the IMU",
        "bring their stamps within " + std::to_string(int(1e3 * kOffset_s_max)) + " ms");
  }
  MotionStart out{best.R_BC, to_seconds(at), Vec3::UnitZ(), best.b_g};
  double f_m_s2 = 0;
  out.gravity_T = gravity(shots, imu, out, f_m_s2);
  check(best, f_m_s2);
  check_board_size(shots, imu, out);
  return out;
}

}  // namespace pirvs::tools
