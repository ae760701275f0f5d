#include "modules/mapping/bundle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/base/assert.h"
#include "core/math/dense_solver.h"
#include "core/math/so3.h"
#include "modules/state/body_state.h"

namespace pirvs {
namespace {

constexpr size_t kPointsPerStep = 128;  // ~0.3 ms of an A72
// From here on a residual says only that the match or the point is wrong: it is left out, and costs
// as much as a point behind the camera.
constexpr double kHopeless_sigma2 = 50.0 * 50.0;
constexpr double kRayDamping = 1e-7;  // of a point's block, as a share of its trace

}  // namespace

void Bundle::begin(const Camera* cameras, const ImuNoise& noise, const MappingParams& params) {
  for (int c = 0; c < kCamerasMax; ++c) camera_[c] = cameras[c];
  noise_ = noise;
  params_ = params;
  frames_.clear();
  points_.clear();
  observations_.clear();
  links_.clear();
  wheel_links_.clear();
  prior_frame_ = -1;
  unknowns_ = 0;
  tilt_free_ = false;
  tilted_ = tilted_trial_ = Mat3::Identity();
  tilt_known_.setZero();
  iteration_ = accepted_ = 0;
  errors_known_ = false;
  lambda_ = 1e-4;
  cost_ = std::numeric_limits<double>::infinity();
  robust_.begin(params.robust_sigma);
  start_iteration();
  phase_ = Phase::kMeasure;
}

int Bundle::add_frame(const BodyState& state, bool fixed) {
  if (!fixed && unknowns_ + 15 > kUnknownsMax) return -1;
  Frame* frame = frames_.append();
  if (frame == nullptr) return -1;
  frame->state = frame->trial = state;
  frame->unknown = fixed ? -1 : unknowns_;
  if (!fixed && unknowns_ == 0) pivot_ = state.T_WB.p;
  if (!fixed) unknowns_ += 15;
  for (int c = 0; c < kCamerasMax; ++c) frame->T_CB[c] = camera_[c].T_BC.inverse();
  place_cameras(*frame, state);
  return static_cast<int>(frames_.size()) - 1;
}

void Bundle::place_cameras(Frame& frame, const BodyState& state) const {
  const SE3 T_BW = state.T_WB.inverse();
  for (int c = 0; c < kCamerasMax; ++c) frame.T_CW[c] = frame.T_CB[c] * T_BW;
}

void Bundle::link(int from, int to, const Preintegration& motion, const WheelPath& way) {
  const bool added = links_.push_back(make_link(from, to, motion, noise_)) &&
                     (!way.holds() || wheel_links_.push_back(make_link(from, to, way)));
  PIRVS_ASSERT(added);  // one per free frame
}

void Bundle::set_prior(int frame, const WindowPrior& prior) {
  prior_frame_ = frame;
  prior_ = prior;
}

double Bundle::prior_cost(const BodyState& state) const {
  const Vec15 e = boxminus(state, prior_.mean);
  return e.dot(prior_.information * e - 2.0 * prior_.gradient);
}

int Bundle::add_point(const Vec3& p_W) {
  Point* point = points_.append();
  if (point == nullptr) return -1;
  point->p_W = point->trial = p_W;
  point->first = static_cast<int>(observations_.size());
  point->count = 0;
  return static_cast<int>(points_.size()) - 1;
}

bool Bundle::add_observation(int point, int frame, int camera, const Vec2& uv) {
  PIRVS_ASSERT(point == static_cast<int>(points_.size()) - 1);
  if (!observations_.push_back({static_cast<int16_t>(frame), static_cast<int16_t>(camera),
                                static_cast<float>(uv.x()), static_cast<float>(uv.y())})) {
    return false;
  }
  ++points_.back().count;
  return true;
}

void Bundle::start_iteration() {
  phase_ = Phase::kLinearize;
  next_point_ = 0;
  shares_.clear();
  cost_trial_ = 0;
  std::fill(S_, S_ + static_cast<size_t>(unknowns_) * kUnknownsMax, 0.0);
  std::fill(b_, b_ + unknowns_, 0.0);
}

bool Bundle::step() {
  switch (phase_) {
    case Phase::kMeasure: {
      const size_t end = std::min(points_.size(), next_point_ + 2 * kPointsPerStep);
      for (; next_point_ < end; ++next_point_) measure_point(points_[next_point_]);
      if (next_point_ < points_.size()) return false;
      robust_.settle();
      next_point_ = 0;
      phase_ = Phase::kLinearize;
      return false;
    }
    case Phase::kLinearize: {
      if (next_point_ == 0) start_iteration();
      const size_t end = std::min(points_.size(), next_point_ + kPointsPerStep);
      for (; next_point_ < end; ++next_point_) {
        linearize_point(points_[next_point_]);
        eliminate_point(points_[next_point_]);
      }
      if (next_point_ < points_.size()) return false;
      keep_oldest_vision();
      linearize_links();
      linearize_wheels();
      linearize_tilt();
      cost_ = cost_trial_;
      if (iteration_ == 0) cost_before_ = cost_;
      phase_ = Phase::kSolve;
      return false;
    }
    case Phase::kSolve:
      solve();
      return phase_ == Phase::kDone;
    case Phase::kEvaluate: {
      const size_t end = std::min(points_.size(), next_point_ + 2 * kPointsPerStep);
      for (; next_point_ < end; ++next_point_) cost_trial_ += evaluate_point(points_[next_point_]);
      if (next_point_ < points_.size()) return false;
      judge();
      if (phase_ == Phase::kDone) finish();
      return phase_ == Phase::kDone;
    }
    case Phase::kDone:
      return true;
  }
  return true;
}

// Takes the point's residuals before the first step, for how robust the cost has to be.
void Bundle::measure_point(const Point& point) {
  for (int o = point.first; o < point.first + point.count; ++o) {
    const ObservedPixel& z = observations_[static_cast<size_t>(o)];
    Vec2 uv;
    const Frame& frame = frames_[static_cast<size_t>(z.frame)];
    if (!camera_[z.camera].project(frame.T_CW[z.camera] * point.p_W, uv)) continue;
    robust_.measure((Vec2(z.x, z.y) - uv).squaredNorm() / (params_.sigma_px * params_.sigma_px));
  }
}

// Accumulates the point's own 3 x 3, and per free frame the 6 x 6, the 6 x 3 and the gradient.
void Bundle::linearize_point(Point& point) {
  const double inverse_sigma = 1.0 / params_.sigma_px;
  Mat3 H = Mat3::Zero();
  point.b.setZero();
  point.first_share = static_cast<int>(shares_.size());
  point.share_count = 0;
  int share_frame = -1;
  Share* share = nullptr;
  for (int o = point.first; o < point.first + point.count; ++o) {
    const ObservedPixel& z = observations_[static_cast<size_t>(o)];
    const Frame& frame = frames_[static_cast<size_t>(z.frame)];
    const SE3& T_CW = frame.T_CW[z.camera];
    Vec2 uv;
    Mat23 J_C;
    if (!camera_[z.camera].project(T_CW * point.p_W, uv, J_C)) {
      cost_trial_ +=
          (frame.unknown < 0 ? params_.fixed_weight : 1.0) * robust_.cost(kHopeless_sigma2);
      continue;
    }
    const Vec2 r = (Vec2(z.x, z.y) - uv) * inverse_sigma;
    const double squares = r.squaredNorm();
    const double trust = frame.unknown < 0 ? params_.fixed_weight : 1.0;
    cost_trial_ += trust * robust_.cost(squares);
    if (squares > kHopeless_sigma2) continue;
    const double weight = trust * robust_.weight(squares);
    const Mat23 J_point = J_C * T_CW.R * inverse_sigma;
    const Mat23 WJ_point = weight * J_point;
    H.noalias() += WJ_point.transpose() * J_point;
    point.b.noalias() += WJ_point.transpose() * r;
    if (frame.unknown < 0) continue;
    if (share == nullptr || z.frame != share_frame) {
      share = shares_.append();
      if (share == nullptr) continue;  // counted by the caller as a full bundle
      share->unknown = frame.unknown;
      share->W.setZero();
      share_frame = z.frame;
      ++point.share_count;
    }
    const SE3& T_CB = frame.T_CB[z.camera];
    const Vec3 p_B = frame.state.T_WB.R.transpose() * (point.p_W - frame.state.T_WB.p);
    Mat26 J;
    J.leftCols<3>() = (J_C * T_CB.R * inverse_sigma) * skew(p_B);
    J.rightCols<3>() = -J_point;
    const Mat26 WJ = weight * J;
    share->W.noalias() += WJ.transpose() * J_point;
    const Vec6 g = WJ.transpose() * r;
    const int at = frame.unknown;
    for (int i = 0; i < 6; ++i) {
      double* out = row(at + i) + at;
      for (int j = i; j < 6; ++j) out[j] += WJ(0, i) * J(0, j) + WJ(1, i) * J(1, j);
      b_[at + i] += g[i];
    }
  }
  // A point that is held along one ray only, the other observations being far off, would not invert
  // well; three times its distance as its standard deviation costs nothing.
  H.diagonal().array() += 1e-6 + kRayDamping * H.trace();
  point.H_inverse = H.inverse();
}

// Schur complement: takes the point out of the system, frame pair by frame pair.
void Bundle::eliminate_point(const Point& point) {
  for (int a = 0; a < point.share_count; ++a) {
    const Share& A = shares_[static_cast<size_t>(point.first_share + a)];
    const Mat63 WH = A.W * point.H_inverse;
    const Vec6 g = WH * point.b;
    for (int i = 0; i < 6; ++i) b_[A.unknown + i] -= g[i];
    for (int c = a; c < point.share_count; ++c) {
      const Share& C = shares_[static_cast<size_t>(point.first_share + c)];
      const Mat6 block = WH * C.W.transpose();
      for (int i = 0; i < 6; ++i) {
        double* out = row(A.unknown + i) + C.unknown;
        for (int j = a == c ? i : 0; j < 6; ++j) out[j] -= block(i, j);
      }
    }
  }
}

// So far the system holds vision alone, all points eliminated.
void Bundle::keep_oldest_vision() {
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) oldest_vision_(i, j) = row(std::min(i, j))[std::max(i, j)];
  }
}

void Bundle::add_block(int at_row, int at_column, const Mat15& block) {
  for (int i = 0; i < 15; ++i) {
    double* out = row(at_row + i) + at_column;
    for (int j = at_row == at_column ? i : 0; j < 15; ++j) out[j] += block(i, j);
  }
}

void Bundle::linearize_links() {
  for (const ImuLink& link : links_) {
    const Frame& a = frames_[static_cast<size_t>(link.from)];
    const Frame& b = frames_[static_cast<size_t>(link.to)];
    const Vec15 r = link_residual(link, a.state, b.state);
    Mat15 J_a, J_b;
    link_jacobians(link, a.state, b.state, J_a, J_b);
    const Vec15 Wr = weigh(link, r);
    cost_trial_ += r.dot(Wr);
    const Mat15 WJ_b = weigh(link, J_b);
    if (a.unknown >= 0) {
      const Vec15 g = J_a.transpose() * Wr;
      for (int i = 0; i < 15; ++i) b_[a.unknown + i] -= g[i];
      add_block(a.unknown, a.unknown, J_a.transpose() * weigh(link, J_a));
      add_block(a.unknown, b.unknown, J_a.transpose() * WJ_b);
    }
    const Vec15 g = J_b.transpose() * Wr;
    for (int i = 0; i < 15; ++i) b_[b.unknown + i] -= g[i];
    add_block(b.unknown, b.unknown, J_b.transpose() * WJ_b);
  }
  if (prior_frame_ >= 0) {
    const Frame& frame = frames_[static_cast<size_t>(prior_frame_)];
    const Vec15 g = prior_.gradient - prior_.information * boxminus(frame.state, prior_.mean);
    cost_trial_ += prior_cost(frame.state);
    for (int i = 0; i < 15; ++i) b_[frame.unknown + i] += g[i];
    add_block(frame.unknown, frame.unknown, prior_.information);
  }
}

// They do not change as all tilts as one.
void Bundle::linearize_wheels() {
  for (const WheelLink& link : wheel_links_) {
    const Frame& a = frames_[static_cast<size_t>(link.from)];
    const Frame& b = frames_[static_cast<size_t>(link.to)];
    const Vec3 r = link_residual(link, a.state, b.state);
    Vec3x15 J_a, J_b;
    link_jacobians(link, a.state, b.state, J_a, J_b);
    const Vec3 Wr = link.information * r;
    cost_trial_ += r.dot(Wr);
    const Vec3x15 WJ_b = link.information * J_b;
    if (a.unknown >= 0) {
      Eigen::Map<Vec15>(b_ + a.unknown) -= J_a.transpose() * Wr;
      add_block(a.unknown, a.unknown, J_a.transpose() * (link.information * J_a));
      add_block(a.unknown, b.unknown, J_a.transpose() * WJ_b);
    }
    Eigen::Map<Vec15>(b_ + b.unknown) -= J_b.transpose() * Wr;
    add_block(b.unknown, b.unknown, J_b.transpose() * WJ_b);
  }
}

void Bundle::copy_system(double lambda) {
  const size_t n = static_cast<size_t>(unknowns_);
  for (size_t i = 0; i < n; ++i) {
    std::copy(row(static_cast<int>(i)) + i, row(static_cast<int>(i)) + n,
              factors_ + i * kUnknownsMax + i);
    factors_[i * kUnknownsMax + i] *= 1 + lambda;
  }
  std::copy(b_, b_ + n, delta_);
}

void Bundle::solve() {
  const size_t n = static_cast<size_t>(unknowns_);
  copy_system(lambda_);
  ++iteration_;
  if (n < 15 || !solve_spd(factors_, kUnknownsMax, delta_, n, nullptr, 0)) {
    lambda_ *= 100;
    if (iteration_ >= static_cast<int>(params_.iterations_max)) phase_ = Phase::kDone;
    return;
  }
  const Vec2 tilt = tilt_free_ ? solve_tilt(lambda_) : Vec2(Vec2::Zero());
  apply(delta_, tilt);
  cost_trial_ = evaluate_links();
  const Vec2 so_far = so3_log(tilted_trial_).head<2>();
  cost_trial_ += so_far.dot(tilt_known_ * so_far);
  next_point_ = 0;
  phase_ = Phase::kEvaluate;
}

void Bundle::apply(const double* delta, const Vec2& tilt) {
  SE3 T;  // of all that is
  T.R = so3_exp(Vec3(tilt.x(), tilt.y(), 0));
  T.p = pivot_ - T.R * pivot_;
  tilted_trial_ = T.R * tilted_;
  for (Frame& frame : frames_) {
    if (frame.unknown < 0 && !tilt_free_) continue;
    frame.trial = frame.state;
    if (tilt_free_) move(T, frame.trial);
    if (frame.unknown >= 0) {
      frame.trial = boxplus(frame.trial, Eigen::Map<const Vec15>(delta + frame.unknown));
    }
    place_cameras(frame, frame.trial);
  }
  for (Point& point : points_) {
    Vec3 rhs = point.b;
    for (int s = 0; s < point.share_count; ++s) {
      const Share& share = shares_[static_cast<size_t>(point.first_share + s)];
      rhs -= share.W.transpose() * Eigen::Map<const Vec6>(delta + share.unknown);
    }
    point.trial = point.p_W + point.H_inverse * rhs;
    if (tilt_free_) point.trial = T * point.trial;
  }
}

double Bundle::cost_at(const Vec3& p_W, const Point& point) const {
  double cost = 0;
  for (int o = point.first; o < point.first + point.count; ++o) {
    const ObservedPixel& z = observations_[static_cast<size_t>(o)];
    const Frame& frame = frames_[static_cast<size_t>(z.frame)];
    const double trust = frame.unknown < 0 ? params_.fixed_weight : 1.0;
    Vec2 uv;
    if (!camera_[z.camera].project(frame.T_CW[z.camera] * p_W, uv)) {
      cost += trust * robust_.cost(kHopeless_sigma2);
      continue;
    }
    const Vec2 r = (Vec2(z.x, z.y) - uv) / params_.sigma_px;
    cost += trust * robust_.cost(r.squaredNorm());
  }
  return cost;
}

// A point takes an undamped Gauss-Newton step, which may carry it behind a camera. Where the old
// position fits the trial poses better, the point keeps it and vetoes nobody else's step.
double Bundle::evaluate_point(Point& point) const {
  Vec3 kept = point.p_W;
  if (tilt_free_) kept = tilted_trial_ * (tilted_.transpose() * (kept - pivot_)) + pivot_;
  const double cost_moved = cost_at(point.trial, point), cost_kept = cost_at(kept, point);
  if (cost_moved <= cost_kept) return cost_moved;
  point.trial = kept;
  return cost_kept;
}

double Bundle::evaluate_links() const {
  double cost = 0;
  for (const ImuLink& link : links_) {
    const Vec15 r = link_residual(link, frames_[static_cast<size_t>(link.from)].trial,
                                  frames_[static_cast<size_t>(link.to)].trial);
    cost += r.dot(weigh(link, r));
  }
  for (const WheelLink& link : wheel_links_) {
    const Vec3 r = link_residual(link, frames_[static_cast<size_t>(link.from)].trial,
                                 frames_[static_cast<size_t>(link.to)].trial);
    cost += r.dot(link.information * r);
  }
  if (prior_frame_ >= 0) cost += prior_cost(frames_[static_cast<size_t>(prior_frame_)].trial);
  return cost;
}

void Bundle::judge() {
  // Until one step has helped, as many again are tried beyond the first: ever shorter ones.
  const int steps = static_cast<int>(params_.iterations_max);
  const bool last = iteration_ >= (accepted_ > 0 ? steps : 2 * steps - 1);
  if (cost_trial_ < cost_) {
    ++accepted_;
    const bool converged = cost_ - cost_trial_ < 1e-3 * cost_;
    cost_ = cost_trial_;
    for (Frame& frame : frames_) frame.state = frame.trial;
    tilted_ = tilted_trial_;
    for (Point& point : points_) point.p_W = point.trial;
    lambda_ = std::max(1e-7, lambda_ * 0.1);
    next_point_ = 0;
    phase_ = last || converged ? Phase::kDone : Phase::kLinearize;
    return;
  }
  for (Frame& frame : frames_) {
    frame.trial = frame.state;
    place_cameras(frame, frame.state);
  }
  lambda_ *= 30;
  phase_ = last ? Phase::kDone : Phase::kSolve;
}

// Covariances, from the undamped system of the last linearization. Reprojection errors do not
// change when the fixed frames and all others move as one rigid body, so the free frames follow an
// error of the fixed ones completely, but in tilt: there the IMU links and the prior resist. The
// newest frame's covariance is against the map, as it stands after levelling.
void Bundle::finish() {
  const size_t n = static_cast<size_t>(unknowns_);
  copy_system(0);
  Mat15 information;
  errors_known_ = solve_spd(factors_, kUnknownsMax, delta_, n, information.data(), 15);
  if (!errors_known_) return;
  newest_cov_ = information.llt().solve(Mat15::Identity());
  const auto oldest = std::find_if(frames_.begin(), frames_.end(),
                                   [](const Frame& frame) { return frame.unknown == 0; });
  newest_follows_ = rigid_motion(frames_.back().state, pivot_);
  oldest_follows_ = rigid_motion(oldest->state, pivot_).topRows<6>();
  (void)solve_tilt(0);
  for (int axis = 0; axis < 2; ++axis) {
    newest_follows_.col(axis) -= Eigen::Map<const Vec15>(X_[axis] + n - 15);
    oldest_follows_.col(axis) -= Eigen::Map<const Vec6>(X_[axis]);
  }
  if (tilt_free_) {
    Eigen::Matrix<double, 15, 2> X;
    for (int axis = 0; axis < 2; ++axis) X.col(axis) = Eigen::Map<const Vec15>(X_[axis] + n - 15);
    newest_cov_ += X * tilt_cov_ * X.transpose();
  }
  for (int i = 0; i < 6; ++i) {
    std::fill(delta_, delta_ + n, 0.0);
    delta_[i] = 1;
    solve_factored(factors_, kUnknownsMax, delta_, n);
    oldest_pose_cov_.col(i) = Eigen::Map<const Vec6>(delta_);
  }
}

double Bundle::residual_sigma(int point, int observation) const {
  const Point& p = points_[static_cast<size_t>(point)];
  const ObservedPixel& z = observations_[static_cast<size_t>(p.first + observation)];
  Vec2 uv;
  if (!camera_[z.camera].project(frames_[static_cast<size_t>(z.frame)].T_CW[z.camera] * p.p_W,
                                 uv)) {
    return std::numeric_limits<double>::infinity();
  }
  return (Vec2(z.x, z.y) - uv).norm() / params_.sigma_px;
}

}  // namespace pirvs
