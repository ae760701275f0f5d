#include "tools/calib/board_scale.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "modules/imu/gravity.h"

namespace pirvs::tools {
namespace {

constexpr double kSpan_s = 0.15, kSpan_s_max = 0.25;  // of each half of a second difference
constexpr int kN = 10;                                // scale, lever arm, gravity, bias
using VecN = Eigen::Matrix<double, kN, 1>;
using MatN = Eigen::Matrix<double, kN, kN>;
using Rows = Eigen::Matrix<double, 3, kN>;

struct Body {
  double t_s = 0;  // on the IMU's clock
  Mat3 R_TB;
  Vec3 p_TC;
};

// Forces and turned biases between two times, weighted by a triangle about the middle.
struct Felt {
  Vec3 f_T = Vec3::Zero();
  Mat3 R_TB = Mat3::Zero();
  double weight = 0;
};

Mat3 attitude(const Body& a, const Body& b, double t_s) {
  const double s = std::clamp((t_s - a.t_s) / (b.t_s - a.t_s), 0.0, 1.0);
  return a.R_TB * so3_exp(s * so3_log(a.R_TB.transpose() * b.R_TB));
}

Felt feel(const std::vector<ImuSample>& imu, TimeNs epoch, const Body& a, const Body& m,
          const Body& b) {
  const TimeNs begin = epoch + from_seconds(a.t_s);
  auto at = std::lower_bound(imu.begin(), imu.end(), begin,
                             [](const ImuSample& s, TimeNs t) { return s.t < t; });
  Felt out;
  for (; at + 1 < imu.end(); ++at) {
    const double t_s = to_seconds(at->t - epoch);
    if (t_s >= b.t_s) break;
    const double dt_s = to_seconds((at + 1)->t - at->t);
    // The triangle falls to zero at both ends, which need not be equally far.
    const double w =
        t_s < m.t_s ? (t_s - a.t_s) : (b.t_s - t_s) * (m.t_s - a.t_s) / (b.t_s - m.t_s);
    const Mat3 R = t_s < m.t_s ? attitude(a, m, t_s) : attitude(m, b, t_s);
    out.f_T += w * dt_s * (R * at->f_B);
    out.R_TB += w * dt_s * R;
    out.weight += w * dt_s;
  }
  return out;
}

// p(b) (m - a) / (b - m) ... : the second difference that the triangle's integral gives.
template <class T>
T second_difference(const T& a, const T& m, const T& b, double before_s, double after_s) {
  return a - m + (b - m) * (before_s / after_s);
}

}  // namespace

bool board_scale(const std::vector<PosedShot>& shots, const std::vector<ImuSample>& imu,
                 const MotionStart& start, double& scale, double& sigma) {
  const TimeNs epoch = shots.front().shot.t;
  std::vector<Body> bodies;
  for (const PosedShot& shot : shots) {
    const SE3 T_TC = shot.T_C0T.inverse();
    bodies.push_back({to_seconds(shot.shot.t - epoch) + start.offset_s,
                      T_TC.R * start.R_BC.transpose(), T_TC.p});
  }
  VecN prior;
  prior << 1e3, 0.5, 0.5, 0.5, 20, 20, 20, 0.5, 0.5, 0.5;
  MatN H = prior.array().square().inverse().matrix().asDiagonal();
  VecN g = VecN::Zero();
  double squares = 0;
  size_t rows = 0, i = 0, k = 0;
  for (size_t m = 0; m < bodies.size(); ++m) {
    const double t_s = bodies[m].t_s;
    while (i < m && bodies[i + 1].t_s < t_s - kSpan_s) ++i;
    while (k + 1 < bodies.size() && bodies[k].t_s < t_s + kSpan_s) ++k;
    const double before_s = t_s - bodies[i].t_s, after_s = bodies[k].t_s - t_s;
    if (before_s < 0.5 * kSpan_s || before_s > kSpan_s_max) continue;
    if (after_s < 0.5 * kSpan_s || after_s > kSpan_s_max) continue;
    const Felt felt = feel(imu, epoch, bodies[i], bodies[m], bodies[k]);
    // scale * DDp + DDR l = felt - gravity * weight - felt R * bias
    Rows J;
    J.col(0) = second_difference(bodies[i].p_TC, bodies[m].p_TC, bodies[k].p_TC, before_s, after_s);
    J.middleCols<3>(1) =
        second_difference(bodies[i].R_TB, bodies[m].R_TB, bodies[k].R_TB, before_s, after_s);
    J.middleCols<3>(4) = felt.weight * Mat3::Identity();
    J.middleCols<3>(7) = felt.R_TB;
    H += J.transpose() * J * 1e6;  // a millimetre
    g += J.transpose() * felt.f_T * 1e6;
    squares += felt.f_T.squaredNorm() * 1e6;
    rows += 3;
  }
  if (rows < 60) return false;
  const VecN x = H.ldlt().solve(g);
  const double left = std::max(0.0, squares - x.dot(g)) / double(rows - kN);
  // Neighbours share their samples: about one in five stands for itself.
  sigma = std::sqrt(5 * std::max(left, 0.01) * H.inverse()(0, 0)) * std::max(1.0, x[0]);
  scale = x[0];
  return sigma < kScaleSigma_max;
}

}  // namespace pirvs::tools
