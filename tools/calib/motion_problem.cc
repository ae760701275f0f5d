#include "tools/calib/motion_problem.h"

#include <ceres/loss_function.h>
#include <ceres/sphere_manifold.h>

#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "modules/imu/gravity.h"
#include "tools/calib/tag_image.h"

namespace pirvs::tools {
namespace {

constexpr double kPadding_s = 0.05;    // of the spline beyond the first and last image
constexpr double kCauchy_sigmas = 10;  // of a whole sample or image
constexpr double kIdentity9[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
constexpr double kIdentity6[6] = {1, 0, 1, 0, 0, 1};

Eigen::VectorXd constant(int n, double value) { return Eigen::VectorXd::Constant(n, value); }

SE3 between(const SE3& a, const SE3& b, double s) {
  return {a.R * so3_exp(s * so3_log(a.R.transpose() * b.R)), a.p + s * (b.p - a.p)};
}

}  // namespace

int MotionUnknowns::segment(double t_s) const {
  return std::clamp(int(std::floor((t_s - t0_s) / dt_s)), 0, segments() - 1);
}

SE3 MotionUnknowns::T_TB(double t_s) const {
  const int first = segment(t_s);
  const SplineBasis basis = spline_basis((t_s - t0_s) / dt_s - first, dt_s);
  const double* q[kSplineOrder];
  SE3 out;
  out.p.setZero();
  for (int k = 0; k < kSplineOrder; ++k) {
    q[k] = q_TB[size_t(first + k)].q;
    out.p += basis.b[0][k] * p_TB[size_t(first + k)];
  }
  out.R = rotation_at(q, basis, false).R_TB;
  return out;
}

MotionProblem::MotionProblem(const Target& target, const CameraRig& rig,
                             const std::vector<PosedShot>& shots, const std::vector<ImuSample>& imu,
                             const ImuCameraOptions& options)
    : target_(target),
      rig_(rig),
      shots_(shots),
      imu_(imu),
      options_(options),
      epoch_(shots.front().shot.t),
      middle_s_(to_seconds(shots.back().shot.t - epoch_) / 2) {}

double MotionProblem::image_time_s(size_t shot, int camera) const {
  const double t_s = to_seconds(shots_[shot].shot.view[camera].t - epoch_);
  return t_s + x_.time[camera][0] + x_.time[camera][1] * (t_s - middle_s_);
}

SE3 MotionProblem::board_in(int camera, double t_s) const {
  const SE3 T_BC{x_.R_BC[camera].matrix(), x_.p_BC[camera]};
  return (x_.T_TB(t_s) * T_BC).inverse();
}

void MotionProblem::make_knots(double knot_s, const std::vector<SE3>& T_TB_at_knots) {
  x_.dt_s = knot_s;
  x_.q_TB.clear();
  x_.p_TB.clear();
  for (const SE3& T_TB : T_TB_at_knots) {
    x_.q_TB.emplace_back(T_TB.R);
    x_.p_TB.push_back(T_TB.p);
  }
  const size_t biases = size_t(std::ceil((x_.end_s() - x_.t0_s) / x_.kBiasKnot_s)) + 1;
  x_.b_g.resize(biases, x_.b_g.empty() ? Vec3(Vec3::Zero()) : x_.b_g.back());
  x_.b_a.resize(biases, Vec3::Zero());
}

void MotionProblem::start(const MotionStart& start, double knot_s) {
  for (int c = 0; c < rig_.cameras; ++c) {
    const SE3 T_CC0 = c == 0 ? SE3{} : rig_.T_C1C0;
    const SE3 T_BC = SE3{start.R_BC, Vec3::Zero()} * T_CC0.inverse();
    x_.R_BC[c] = Rotation(T_BC.R);
    x_.p_BC[c] = T_BC.p;
    x_.time[c][0] = start.offset_s;
    x_.time[c][1] = 0;
    x_.lens[c] = lens_of(rig_.camera[c]);
  }
  std::copy(kIdentity9, kIdentity9 + 9, x_.gyro);
  std::copy(kIdentity6, kIdentity6 + 6, x_.accel);
  x_.gravity_T = start.gravity_T;
  x_.b_g = {start.b_g};
  x_.t0_s = start.offset_s - kPadding_s;
  const double end_s = to_seconds(shots_.back().shot.t - epoch_) + start.offset_s + kPadding_s;
  const int segments = int(std::ceil((end_s - x_.t0_s) / knot_s));
  std::vector<SE3> T_TB;
  size_t at = 0;
  const auto body = [&](size_t i) {
    return shots_[i].T_C0T.inverse() * SE3{start.R_BC.transpose(), Vec3::Zero()};
  };
  for (int k = 0; k < segments + kSplineOrder - 1; ++k) {
    const double t_s = x_.t0_s + (k - 2) * knot_s - start.offset_s;  // on the camera's clock
    while (at + 2 < shots_.size() && to_seconds(shots_[at + 1].shot.t - epoch_) < t_s) ++at;
    const double a_s = to_seconds(shots_[at].shot.t - epoch_);
    const double b_s = to_seconds(shots_[at + 1].shot.t - epoch_);
    T_TB.push_back(
        between(body(at), body(at + 1), std::clamp((t_s - a_s) / (b_s - a_s), 0.0, 1.0)));
  }
  make_knots(knot_s, T_TB);
}

void MotionProblem::refine(double knot_s) {
  const int segments = int(std::ceil((x_.end_s() - x_.t0_s) / knot_s));
  std::vector<SE3> T_TB;
  for (int k = 0; k < segments + kSplineOrder - 1; ++k) {
    T_TB.push_back(x_.T_TB(x_.t0_s + (k - 2) * knot_s));
  }
  problem_.reset();
  make_knots(knot_s, T_TB);
}

// The twelve knots that a time stands on; false outside the spline.
bool MotionProblem::knots_at(double t_s, std::vector<double*>& blocks) {
  if (!(t_s >= x_.t0_s && t_s < x_.end_s())) return false;
  const size_t first = size_t(x_.segment(t_s));
  for (size_t k = 0; k < kSplineOrder; ++k) blocks.push_back(x_.q_TB[first + k].q);
  for (size_t k = 0; k < kSplineOrder; ++k) blocks.push_back(x_.p_TB[first + k].data());
  return true;
}

void MotionProblem::add_imu(const Weights& weights) {
  const double root = std::sqrt(options_.noise.rate_hz);
  auto* const loss = new ceres::CauchyLoss(kCauchy_sigmas);
  for (const ImuSample& sample : imu_) {
    const double t_s = to_seconds(sample.t - epoch_);
    std::vector<double*> blocks;
    if (!knots_at(t_s, blocks)) continue;
    ImuReading reading;
    reading.w_B = sample.w_B;
    reading.f_B = sample.f_B;
    reading.gyro_sigma = options_.noise.gyro_noise * root * weights.gyro_excess;
    reading.accel_sigma = options_.noise.accel_noise * root * weights.accel_excess;
    reading.basis = spline_basis((t_s - x_.t0_s) / x_.dt_s - x_.segment(t_s), x_.dt_s);
    const double at = (t_s - x_.t0_s) / x_.kBiasKnot_s;
    const size_t bias = std::min(size_t(at), x_.b_g.size() - 2);
    reading.bias_share = at - double(bias);
    blocks.insert(blocks.end(),
                  {x_.gravity_T.data(), x_.gyro, x_.accel, x_.b_g[bias].data(),
                   x_.b_g[bias + 1].data(), x_.b_a[bias].data(), x_.b_a[bias + 1].data()});
    problem_->AddResidualBlock(new ImuCost(reading), loss, blocks);
  }
}

void MotionProblem::add_images(const Weights& weights) {
  auto* const loss = new ceres::CauchyLoss(kCauchy_sigmas);
  images_.clear();
  for (size_t i = 0; i < shots_.size(); ++i) {
    for (int c = 0; c < rig_.cameras; ++c) {
      const View& view = shots_[i].shot.view[c];
      if (view.tags.empty()) continue;
      const double t_s = image_time_s(i, c);
      std::vector<double*> blocks;
      if (!knots_at(t_s, blocks)) continue;
      Camera camera = rig_.camera[c];
      set_lens(x_.lens[c].data(), camera);
      const SE3 own = c == 0 ? shots_[i].T_C0T : rig_.T_C1C0 * shots_[i].T_C0T;
      FrameFactor factor;
      BoardRows board;
      const SE3 at = solved_ ? board_in(c, t_s) : own;
      if (!make_frame_factor(camera, target_, view, at, weights.sigma_px, factor, board)) continue;
      blocks.insert(blocks.end(), {x_.R_BC[c].q, x_.p_BC[c].data(), x_.time[c], x_.lens[c].data()});
      const double camera_s = to_seconds(view.t - epoch_);
      auto* const cost = new FrameCost(factor, camera_s, camera_s - middle_s_,
                                       x_.t0_s + x_.segment(t_s) * x_.dt_s, x_.dt_s);
      images_.push_back({problem_->AddResidualBlock(cost, loss, blocks), std::move(board)});
    }
  }
}

void MotionProblem::add_priors() {
  const auto prior = [&](double* block, const Eigen::VectorXd& mean, const Eigen::VectorXd& sigma) {
    problem_->AddResidualBlock(new PriorCost(mean, sigma), nullptr, block);
  };
  prior(x_.gyro, Eigen::Map<const Eigen::VectorXd>(kIdentity9, 9), constant(9, kMatrixSigma));
  prior(x_.accel, Eigen::Map<const Eigen::VectorXd>(kIdentity6, 6), constant(6, kMatrixSigma));
  prior(x_.b_g[0].data(), constant(3, 0), constant(3, kGyroBiasSigma_rad_s));
  prior(x_.b_a[0].data(), constant(3, 0), constant(3, kAccelBiasSigma_m_s2));
  const double root = std::sqrt(x_.kBiasKnot_s);
  for (size_t i = 1; i < x_.b_g.size(); ++i) {
    problem_->AddResidualBlock(new WalkCost(options_.noise.gyro_walk * root), nullptr,
                               x_.b_g[i - 1].data(), x_.b_g[i].data());
    problem_->AddResidualBlock(new WalkCost(options_.noise.accel_walk * root), nullptr,
                               x_.b_a[i - 1].data(), x_.b_a[i].data());
  }
  // A knot at either end that no sample reaches stays where it is.
  for (size_t i = 0; i < x_.q_TB.size(); ++i) {
    prior(x_.p_TB[i].data(), x_.p_TB[i], constant(3, 10));
    if (!problem_->HasParameterBlock(x_.q_TB[i].q)) continue;
    prior(x_.q_TB[i].q, Eigen::Map<const Eigen::VectorXd>(x_.q_TB[i].q, 4), constant(4, 10));
  }
  for (int c = 0; c < rig_.cameras; ++c) {
    prior(x_.p_BC[c].data(), constant(3, 0), constant(3, kPlaceSigma_m));
    Eigen::VectorXd sigma(2);
    sigma << kOffsetSigma_s, kDriftSigma;
    prior(x_.time[c], constant(2, 0), sigma);
  }
}

bool MotionProblem::solve(const Weights& weights, int steps_max) {
  problem_ = std::make_unique<ceres::Problem>();
  add_images(weights);
  add_imu(weights);
  if (problem_->NumResidualBlocks() == 0) return false;
  add_priors();
  auto* const manifold = new RotationManifold;
  std::vector<double*> blocks;
  problem_->GetParameterBlocks(&blocks);
  for (double* block : blocks) {
    if (problem_->ParameterBlockSize(block) == 4) problem_->SetManifold(block, manifold);
  }
  problem_->SetManifold(x_.gravity_T.data(), new ceres::SphereManifold<3>());
  if (!options_.imu_intrinsics) {
    problem_->SetParameterBlockConstant(x_.gyro);
    problem_->SetParameterBlockConstant(x_.accel);
  }
  ceres::Solver::Options how = solver_options(steps_max);
  how.function_tolerance = 1e-6;
  ceres::Solver::Summary summary;
  ceres::Solve(how, problem_.get(), &summary);
  solved_ = true;
  return summary.IsSolutionUsable();
}

// The estimate moves with the board that it took for granted. The first stage's error of the board
// is not correlated with the error that is left here once the board is given: the first stage let
// lens and poses free, so its board follows what of the noise neither of them can explain.
bool MotionProblem::covariance(const Eigen::MatrixXd& board, Eigen::MatrixXd& out) {
  std::vector<double*> blocks;
  for (int c = 0; c < rig_.cameras; ++c) {
    blocks.insert(blocks.end(), {x_.R_BC[c].q, x_.p_BC[c].data(), x_.time[c], x_.lens[c].data()});
  }
  const size_t middle = x_.b_g.size() / 2;
  blocks.insert(blocks.end(), {x_.b_g[middle].data(), x_.b_a[middle].data()});
  if (options_.imu_intrinsics) blocks.insert(blocks.end(), {x_.gyro, x_.accel});
  Eigen::MatrixXd influence;
  if (!marginal_covariance(*problem_, blocks, out, &influence)) return false;
  Eigen::MatrixXd by_board = Eigen::MatrixXd::Zero(out.rows(), board.rows());
  for (size_t i = 0; i < images_.size(); ++i) {
    const Image& image = images_[i];
    double half_square = 0;
    if (!problem_->EvaluateResidualBlock(image.id, false, &half_square, nullptr, nullptr)) {
      return false;
    }
    // As the loss has weighted the rows of `influence`.
    const double weight = 1 / std::sqrt(1 + 2 * half_square / (kCauchy_sigmas * kCauchy_sigmas));
    const auto rows = influence.middleRows<kFrameSize>(kFrameSize * Eigen::Index(i));
    for (size_t k = 0; k < image.board.tags.size(); ++k) {
      by_board.middleCols<3>(3 * image.board.tags[k]) -=
          weight * rows.transpose() * image.board.by_shift.middleCols<3>(3 * Eigen::Index(k));
    }
  }
  out += by_board * board * by_board.transpose();
  return out.allFinite();
}

MotionProblem::Residuals MotionProblem::residuals() const {
  Residuals out;
  double squares[2] = {0, 0};
  std::vector<double> residuals(6);
  for (const ImuSample& sample : imu_) {
    const double t_s = to_seconds(sample.t - epoch_);
    if (!(t_s >= x_.t0_s && t_s < x_.end_s())) continue;
    const int first = x_.segment(t_s);
    const SplineBasis basis = spline_basis((t_s - x_.t0_s) / x_.dt_s - first, x_.dt_s);
    const double at = (t_s - x_.t0_s) / x_.kBiasKnot_s;
    const size_t bias = std::min(size_t(at), x_.b_g.size() - 2);
    const ImuCost cost({sample.w_B, sample.f_B, 1, 1, basis, at - double(bias)});
    std::vector<const double*> x;
    for (size_t k = 0; k < kSplineOrder; ++k) x.push_back(x_.q_TB[size_t(first) + k].q);
    for (size_t k = 0; k < kSplineOrder; ++k) x.push_back(x_.p_TB[size_t(first) + k].data());
    x.insert(x.end(), {x_.gravity_T.data(), x_.gyro, x_.accel, x_.b_g[bias].data(),
                       x_.b_g[bias + 1].data(), x_.b_a[bias].data(), x_.b_a[bias + 1].data()});
    cost.Evaluate(x.data(), residuals.data(), nullptr);
    for (size_t i = 0; i < 6; ++i) squares[i / 3] += residuals[i] * residuals[i];
    ++out.samples;
  }
  const double n = 3 * double(std::max<size_t>(out.samples, 1));
  const double root = std::sqrt(options_.noise.rate_hz);
  // Each knot takes three of the samples' degrees of freedom, of either sensor.
  const double left = std::max(0.1, 1 - 3 * double(x_.q_TB.size()) / n);
  out.gyro = std::sqrt(squares[0] / n);
  out.accel = std::sqrt(squares[1] / n);
  out.gyro_excess = out.gyro / std::sqrt(left) / (options_.noise.gyro_noise * root);
  out.accel_excess = out.accel / std::sqrt(left) / (options_.noise.accel_noise * root);
  for (int c = 0; c < rig_.cameras; ++c) {
    Camera camera = rig_.camera[c];
    set_lens(x_.lens[c].data(), camera);
    std::vector<double> errors;
    for (size_t i = 0; i < shots_.size(); ++i) {
      if (shots_[i].shot.view[c].tags.empty()) continue;
      const SE3 T_CT = board_in(c, image_time_s(i, c));
      for (const SeenTag& tag : shots_[i].shot.view[c].tags) {
        TagImage image;
        if (!project_tag(camera, target_, T_CT, tag.id, image)) continue;
        errors.push_back((image.uv - tag.uv).squaredNorm() / 2);
      }
    }
    if (errors.empty()) continue;
    std::sort(errors.begin(), errors.end());
    const size_t inliers = errors.size() - errors.size() / 100;  // a tag in a hundred is wrong
    double sum = 0;
    for (size_t i = 0; i < inliers; ++i) sum += errors[i];
    out.px[c] = std::sqrt(sum / double(inliers));
  }
  return out;
}

}  // namespace pirvs::tools
