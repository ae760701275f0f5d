#include "modules/tracking/starter.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/math/so3.h"
#include "modules/matching/triangulate.h"

namespace pirvs {
namespace {

constexpr int kPointsMin = 20;             // stereo points worth starting an attempt with
constexpr int kInliersMin = 12;            // located points below which an attempt ends
constexpr double kGravityTolerance = 1.2;  // m/s^2, before the norm is imposed
constexpr double kFitTolerance_m = 0.05;

Mat15 start_cov(bool at_rest) {
  Vec15 sigma;
  sigma.segment<3>(0).setConstant(0.02);                    // rad
  sigma.segment<3>(3).setConstant(0.01);                    // m
  sigma.segment<3>(6).setConstant(at_rest ? 0.02 : 0.15);   // m/s
  sigma.segment<3>(9).setConstant(at_rest ? 0.005 : 0.02);  // rad/s
  sigma.segment<3>(12).setConstant(0.1);                    // m/s^2
  return sigma.cwiseAbs2().asDiagonal();
}

int pairs(const Observations& left) {
  int count = 0;
  for (const Observation& sighting : left) count += sighting.stereo >= 0 ? 1 : 0;
  return count;
}

// The rotation with the given heading that stands gravity upright.
Mat3 upright(const Vec3& g_B0, const Mat3& R_heading) {
  const Vec3 z_B = -g_B0.normalized();
  // The axis of B that was least vertical keeps its heading.
  Vec3 x_B = R_heading.transpose() * Vec3::UnitX();
  x_B -= x_B.dot(z_B) * z_B;
  if (x_B.norm() < 0.1) x_B = z_B.cross(R_heading.transpose() * Vec3::UnitY()).cross(z_B);
  x_B.normalize();
  Mat3 R_WB;
  R_WB.row(0) = x_B.transpose();
  R_WB.row(1) = z_B.cross(x_B).transpose();
  R_WB.row(2) = z_B.transpose();
  return R_WB;
}

}  // namespace

void Starter::configure(const Camera* cameras, const ImuNoise& noise, const FilterParams& filter,
                        const TrackerParams& params, const ImuHistory* imu) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  T_C1C0_ = camera_[1].T_BC.inverse() * camera_[0].T_BC;
  noise_ = noise;
  imu_ = imu;
  params_ = params;
  locator_.configure(cameras, noise, filter);
  for (int c = 0; c < kCamerasMax; ++c) mono_[c].configure(cameras[c], c, noise, params);
  reset();
}

void Starter::configure_wheels(const SE3& T_BV, const WheelParams& params,
                               const WheelHistory* wheels) {
  no_way_.configure(T_BV, params);
  wheels_ = wheels;
}

void Starter::reset() {
  frames_.clear();
  points_[0].clear();
  points_[1].clear();
  keyframes_.clear();
}

bool Starter::wants_keyframe(TimeNs t) const {
  return frames_.empty() || to_seconds(t - keyframes_.back().state.t) >= params_.start_keyframe_s;
}

Status Starter::add_frame(TimeNs t, const Tracks& left, const Tracks& right,
                          const Observations* keyframe, const StandstillDetector& standstill,
                          const SE3& origin) {
  if (keyframe != nullptr && standstill.rest_s() >= params_.start_s &&
      pairs(keyframe[0]) >= kPointsMin) {
    keyframes_.clear();
    add_keyframe(t, keyframe);
    finish_at_rest(standstill, origin);
    return Status::kOk;
  }
  if (frames_.empty()) return begin(t, keyframe);
  SE3 T_B0B = frames_.back().T_B0B;
  T_B0B.R = T_B0B.R * between(frames_.back().t, t, Vec3::Zero()).dR;
  if (frames_.size() > 1) T_B0B.p += T_B0B.p - frames_[frames_.size() - 2].T_B0B.p;
  const int inliers = locate(T_B0B, left, right);
  if (inliers < kInliersMin || frames_.full() || !imu_->covers(frames_[0].t)) {
    reset();
    return Status::kStale;
  }
  *frames_.append() = {t, T_B0B, keyframe != nullptr};
  if (keyframe != nullptr) {
    add_points(T_B0B, keyframe);
    add_keyframe(t, keyframe);
  }
  if (keyframe == nullptr || to_seconds(t - frames_[0].t) < params_.start_s) return Status::kEmpty;
  if (standstill.at_rest()) return Status::kEmpty;  // soon for long enough
  const Status status = finish(origin);
  if (status == Status::kStale && !keyframes_.full()) return Status::kEmpty;  // look longer
  if (status != Status::kOk) reset();
  return status;
}

Status Starter::begin(TimeNs t, const Observations* keyframe) {
  if (keyframe == nullptr || !has_sample_at(t)) return Status::kStale;
  reset();
  add_points(SE3{}, keyframe);
  if (points_[0].size() < kPointsMin) {
    reset();
    return Status::kStale;
  }
  *frames_.append() = {t, SE3{}, true};
  add_keyframe(t, keyframe);
  return Status::kEmpty;
}

const Starter::Point* Starter::find(int camera, TrackId track) const {
  for (const Point& point : points_[camera]) {
    if (point.track == track) return &point;
  }
  return nullptr;
}

// Pose against the points of the attempt.
int Starter::locate(SE3& T_B0B, const Tracks& left, const Tracks& right) {
  correspondences_.clear();
  const Tracks* tracks[kCamerasMax] = {&left, &right};
  for (int c = 0; c < kCamerasMax; ++c) {
    for (const Track& track : *tracks[c]) {
      const Point* point = find(c, track.id);
      if (point == nullptr) continue;
      Correspondence* added = correspondences_.append();
      if (added == nullptr) break;
      *added = {point->p_B0, point->cov, Vec2(track.x, track.y), 1.0, c, Gate::kAccepted};
    }
  }
  const int inliers = locator_.locate(T_B0B, {0.03, 0.15, 0.1}, correspondences_);
  T_B0B = locator_.state().T_WB;
  return inliers;
}

void Starter::add_points(const SE3& T_B0B, const Observations* keyframe) {
  const SE3 T_CB0[kCamerasMax] = {(T_B0B * camera_[0].T_BC).inverse(),
                                  (T_B0B * camera_[1].T_BC).inverse()};
  for (const Observation& left : keyframe[0]) {
    if (left.stereo < 0 || find(0, left.track) != nullptr) continue;
    const Observation& right = keyframe[1][static_cast<size_t>(left.stereo)];
    const View views[2] = {{&camera_[0], T_CB0[0], Vec2(left.x, left.y)},
                           {&camera_[1], T_CB0[1], Vec2(right.x, right.y)}};
    Triangulated point;
    if (!triangulate(views, 2, 1.0, point) || point.residual_px_max > 2.0) continue;
    // Twice the formal covariance: an error in depth stays the same for as long as the point lives.
    (void)points_[0].push_back({left.track, point.p_W, 2.0 * point.cov});
    (void)points_[1].push_back({right.track, point.p_W, 2.0 * point.cov});
  }
}

void Starter::add_keyframe(TimeNs t, const Observations* keyframe) {
  KeyframeMessage* message = keyframes_.append();
  if (message == nullptr) return;
  message->state.t = t;
  message->observations[0] = keyframe[0];
  message->observations[1] = keyframe[1];
}

Preintegration Starter::between(TimeNs t0, TimeNs t1, const Vec3& b_g) const {
  return integrate(*imu_, t0, t1, b_g, Vec3::Zero(), noise_);
}

WheelPath Starter::way_between(TimeNs t0, TimeNs t1, const Vec3& b_g) const {
  if (wheels_ == nullptr) return no_way_;
  return integrate(*imu_, *wheels_, t0, t1, b_g, noise_, no_way_);
}

bool Starter::solve_gyro_bias(Vec3& b_g) const {
  b_g.setZero();
  for (int iteration = 0; iteration < 2; ++iteration) {
    Mat3 H = Mat3::Identity() * 1e-6;
    Vec3 g = Vec3::Zero();
    for (size_t k = 1; k < frames_.size(); ++k) {
      if (!frames_[k].keyframe) continue;
      const Preintegration motion = between(frames_[0].t, frames_[k].t, b_g);
      const Vec3 r = so3_log(motion.dR.transpose() * frames_[k].T_B0B.R);
      H += motion.dR_dbg.transpose() * motion.dR_dbg;
      g += motion.dR_dbg.transpose() * r;
    }
    b_g += H.inverse() * g;
  }
  return b_g.norm() < 0.5;
}

// p_k = v0 t + g t^2 / 2 + dp_k for all frames, linear in v0 and g; then g on its sphere.
bool Starter::solve_gravity(const Vec3& b_g, Vec3& g_B0, Vec3& v_B0) const {
  Mat6 H = Mat6::Zero();
  Vec6 rhs = Vec6::Zero();
  const auto row = [&](size_t k, Eigen::Matrix<double, 3, 6>& A, Vec3& y) {
    const Preintegration motion = between(frames_[0].t, frames_[k].t, b_g);
    A.leftCols<3>() = Mat3::Identity() * motion.dt_s;
    A.rightCols<3>() = Mat3::Identity() * (0.5 * motion.dt_s * motion.dt_s);
    y = frames_[k].T_B0B.p - motion.dp;
  };
  Eigen::Matrix<double, 3, 6> A;
  Vec3 y;
  for (size_t k = 1; k < frames_.size(); ++k) {
    row(k, A, y);
    H += A.transpose() * A;
    rhs += A.transpose() * y;
  }
  Vec6 x = H.ldlt().solve(rhs);
  if (!x.allFinite() || std::fabs(x.tail<3>().norm() - kGravity_m_s2) > kGravityTolerance) {
    return false;
  }
  for (int iteration = 0; iteration < 4; ++iteration) {
    const Vec3 g = x.tail<3>().normalized() * kGravity_m_s2;
    Mat3 basis;  // columns 0, 1 span the tangent plane of the sphere at g
    basis.col(0) = g.unitOrthogonal();
    basis.col(1) = g.normalized().cross(basis.col(0));
    Eigen::Matrix<double, 6, 5> N = Eigen::Matrix<double, 6, 5>::Zero();
    N.topLeftCorner<3, 3>().setIdentity();
    N.bottomRightCorner<3, 2>() = basis.leftCols<2>();
    Vec6 x0 = Vec6::Zero();
    x0.tail<3>() = g;
    const Eigen::Matrix<double, 5, 5> M = N.transpose() * H * N;
    x = x0 + N * M.ldlt().solve(N.transpose() * (rhs - H * x0));
  }
  v_B0 = x.head<3>();
  g_B0 = x.tail<3>().normalized() * kGravity_m_s2;
  double squares = 0;
  for (size_t k = 1; k < frames_.size(); ++k) {
    row(k, A, y);
    Vec6 solution;
    solution << v_B0, g_B0;
    squares += (A * solution - y).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(frames_.size() - 1)) < kFitTolerance_m;
}

Status Starter::finish(const SE3& origin) {
  Vec3 b_g, g_B0, v_B0;
  at_rest_ = false;
  if (!solve_gyro_bias(b_g) || !solve_gravity(b_g, g_B0, v_B0)) return Status::kStale;
  const Mat3 R_WB0 = upright(g_B0, origin.R);
  const Vec3 g_W(0, 0, -kGravity_m_s2);
  for (KeyframeMessage& message : keyframes_) {
    const auto* frame = std::find_if(frames_.begin(), frames_.end(),
                                     [&](const Frame& f) { return f.t == message.state.t; });
    const Preintegration motion = between(frames_[0].t, frame->t, b_g);
    message.state.T_WB.R = R_WB0 * frame->T_B0B.R;
    message.state.T_WB.p = origin.p + R_WB0 * frame->T_B0B.p;
    message.state.v_WB = R_WB0 * (v_B0 + motion.dv) + g_W * motion.dt_s;
    message.state.b_g = b_g;
    message.state.b_a.setZero();
  }
  for (size_t i = 1; i < keyframes_.size(); ++i) {
    const TimeNs t0 = keyframes_[i - 1].state.t, t1 = keyframes_[i].state.t;
    keyframes_[i].from_previous = between(t0, t1, b_g);
    keyframes_[i].way_from_previous = way_between(t0, t1, b_g);
  }
  seal_keyframes();
  cov_ = start_cov(at_rest_);
  return Status::kOk;
}

void Starter::seal_keyframes() {
  for (KeyframeMessage& message : keyframes_) {
    message.linked = true;
    message.adjust = message.restart = false;
    message.at_rest = at_rest_;
  }
  keyframes_[0].restart = true;
  keyframes_[0].linked = false;
  keyframes_.back().adjust = true;
  state_ = keyframes_.back().state;
}

void Starter::move(const SE3& T) {
  for (KeyframeMessage& message : keyframes_) pirvs::move(T, message.state);
  state_ = keyframes_.back().state;
  const Mat15 A = error_transform(T);
  cov_ = (A * cov_ * A.transpose()).eval();
}

// ---- one camera -------------------------------------------------------------------------------

Status Starter::add_mono_frame(TimeNs t, int c, const Observations* keyframe,
                               const StandstillDetector& standstill, const SE3& origin) {
  if (keyframe == nullptr) return Status::kEmpty;
  const bool missing = !has_sample_at(t) || (!idle() && !imu_->covers(keyframes_[0].state.t));
  if (missing || keyframe[c].size() < kPointsMin) {
    reset();
    return Status::kStale;
  }
  if (frames_.empty()) {
    reset();
    *frames_.append() = {t, SE3{}, true};
  }
  if (keyframes_.full()) forget_oldest_keyframe();
  add_keyframe(t, keyframe);
  if (to_seconds(t - keyframes_[0].state.t) < params_.start_s) return Status::kEmpty;
  if (standstill.at_rest()) {
    finish_at_rest(standstill, origin);
    return Status::kOk;
  }
  MonoStart start;
  const MonoStarter::Wheels wheels{wheels_, no_way_};
  if (mono_[c].solve(*imu_, wheels, keyframes_, start) != Status::kOk) return Status::kEmpty;
  finish_mono(start, origin);
  return Status::kOk;
}

void Starter::forget_oldest_keyframe() {
  for (size_t i = 1; i < keyframes_.size(); ++i) keyframes_[i - 1] = keyframes_[i];
  keyframes_.pop_back();
}

void Starter::finish_mono(const MonoStart& start, const SE3& origin) {
  at_rest_ = false;
  const Mat3 R_WB0 = upright(start.g_B0, origin.R);
  Preintegration motion;
  for (size_t i = 0; i < keyframes_.size(); ++i) {
    KeyframeMessage& message = keyframes_[i];
    const TimeNs t = message.state.t;
    motion = integrate(*imu_, keyframes_[0].state.t, t, start.b_g, start.b_a, noise_);
    const double dt_s = motion.dt_s;
    message.state.T_WB.R = R_WB0 * motion.dR;
    message.state.T_WB.p =
        origin.p + R_WB0 * (start.v_B0 * dt_s + 0.5 * dt_s * dt_s * start.g_B0 + motion.dp);
    message.state.v_WB = R_WB0 * (start.v_B0 + start.g_B0 * dt_s + motion.dv);
    message.state.b_g = start.b_g;
    message.state.b_a = start.b_a;
    if (i == 0) continue;
    message.from_previous =
        integrate(*imu_, keyframes_[i - 1].state.t, t, start.b_g, start.b_a, noise_);
    message.way_from_previous = way_between(keyframes_[i - 1].state.t, t, start.b_g);
  }
  seal_keyframes();
  cov_ = mono_start_cov(start, motion, R_WB0);
}

// One keyframe says all. From one camera it is without depth: points come when the body begins to
// move, by dead reckoning.
void Starter::finish_at_rest(const StandstillDetector& standstill, const SE3& origin) {
  at_rest_ = true;
  keyframes_[0] = keyframes_.back();
  keyframes_.resize(1);
  BodyState& state = keyframes_[0].state;
  const Vec3 up_B = standstill.mean_force_B().normalized();
  state.T_WB.R = upright(-up_B, origin.R);
  state.T_WB.p = origin.p;
  state.v_WB.setZero();
  state.b_g = standstill.mean_rate_B();
  state.b_a = standstill.mean_force_B() - kGravity_m_s2 * up_B;
  seal_keyframes();
  cov_ = start_cov(at_rest_);
}

}  // namespace pirvs
