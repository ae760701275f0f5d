#include "tools/calib/camera_adjustment.h"

#include <ceres/loss_function.h>
#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "tools/calib/lens.h"
#include "tools/calib/solver.h"

namespace pirvs::tools {
namespace {

constexpr double kOutlier_sigmas = 5;
constexpr double kCauchy_sigmas = 3;
constexpr double kStartSigma_px = 1;
// How far a tag may be off its place on a bent board. Print is exact in its plane: more freedom
// there is the principal point's, where all views are upright.
constexpr double kTagSigma_m[3] = {0.02e-3, 0.02e-3, 1e-3};
constexpr int kRounds = 3;
constexpr int kStepsMax = 40;

using Mat24 = Eigen::Matrix<double, 2, 4, Eigen::RowMajor>;
using Row23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using Row28 = Eigen::Matrix<double, 2, kLensSize, Eigen::RowMajor>;

struct Sighting {
  CameraModel model;
  Vec3 p_T, outward_T;  // on the flat board
  Vec2 uv;

  Vec3 seen_T(double inset_m, const double* shift) const {
    return p_T - inset_m * outward_T + Eigen::Map<const Vec3>(shift);
  }
};

// r = h(T_CT p_T) - uv and its parts by p_C and lens.
bool residual(const Sighting& sighting, const double* lens, const Vec3& p_C, double* r, Mat23& J,
              Mat28& J_lens) {
  Camera camera;
  camera.model = sighting.model;
  set_lens(lens, camera);
  Vec2 uv;
  if (!project(camera, p_C, uv, J, J_lens)) return false;
  Eigen::Map<Vec2>(r).noalias() = uv - sighting.uv;
  return true;
}

// Ceres asks for some blocks alone, and has rows where we have columns.
template <class Row, class J>
void put(double* out, const J& jacobian) {
  if (out == nullptr) return;
  Eigen::Map<Row> block(out);
  block = jacobian;
}

void put_rotation(double* out, const Mat23& J) {
  Mat24 block;
  block << J, Vec2::Zero();
  put<Mat24>(out, block);
}

// Unknowns: lens, inset, q and p of T_C0T, shift of the tag.
class LeftCorner final : public ceres::SizedCostFunction<2, kLensSize, 1, 4, 3, 3> {
 public:
  explicit LeftCorner(const Sighting& sighting) : sighting_(sighting) {}

  bool Evaluate(double const* const* x, double* r, double** jacobians) const override {
    const Mat3 R = matrix_of(x[2]);
    const Vec3 p_T = sighting_.seen_T(*x[1], x[4]);
    Mat23 J;
    Mat28 J_lens;
    const Vec3 p_C = R * p_T + Eigen::Map<const Vec3>(x[3]);
    if (!residual(sighting_, x[0], p_C, r, J, J_lens)) return false;
    if (jacobians == nullptr) return true;
    put<Row28>(jacobians[0], J_lens);
    put<Vec2>(jacobians[1], -J * R * sighting_.outward_T);
    put_rotation(jacobians[2], -J * R * skew(p_T));
    put<Row23>(jacobians[3], J);
    put<Row23>(jacobians[4], J * R);
    return true;
  }

 private:
  Sighting sighting_;
};

// Unknowns: lens, inset, q and p of T_C0T, shift of the tag, q and p of T_C1C0.
class RightCorner final : public ceres::SizedCostFunction<2, kLensSize, 1, 4, 3, 3, 4, 3> {
 public:
  explicit RightCorner(const Sighting& sighting) : sighting_(sighting) {}

  bool Evaluate(double const* const* x, double* r, double** jacobians) const override {
    const Mat3 R = matrix_of(x[2]), R_C1C0 = matrix_of(x[5]);
    const Vec3 p_T = sighting_.seen_T(*x[1], x[4]);
    const Vec3 p_C0 = R * p_T + Eigen::Map<const Vec3>(x[3]);
    Mat23 J;
    Mat28 J_lens;
    const Vec3 p_C = R_C1C0 * p_C0 + Eigen::Map<const Vec3>(x[6]);
    if (!residual(sighting_, x[0], p_C, r, J, J_lens)) return false;
    if (jacobians == nullptr) return true;
    const Mat23 J_C0 = J * R_C1C0;
    put<Row28>(jacobians[0], J_lens);
    put<Vec2>(jacobians[1], -J_C0 * R * sighting_.outward_T);
    put_rotation(jacobians[2], -J_C0 * R * skew(p_T));
    put<Row23>(jacobians[3], J_C0);
    put<Row23>(jacobians[4], J_C0 * R);
    put_rotation(jacobians[5], -J_C0 * skew(p_C0));
    put<Row23>(jacobians[6], J);
    return true;
  }

 private:
  Sighting sighting_;
};

struct Pose {
  Rotation rotation;
  Vec3 p;
  explicit Pose(const SE3& T = {}) : rotation(T.R), p(T.p) {}
  SE3 transform() const { return {rotation.matrix(), p}; }
};

// All unknowns where Ceres finds them.
struct Unknowns {
  LensVector lens[2];
  Pose T_C1C0;
  std::vector<Pose> T_C0T;
  std::vector<Vec2> inset_m;
  std::vector<Vec3> shift_T;

  Unknowns(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& shots)
      : T_C1C0(rig.T_C1C0), shift_T(target.shift_T) {
    shift_T.resize(size_t(target.tags()), Vec3::Zero());
    for (int c = 0; c < 2; ++c) lens[c] = lens_of(rig.camera[c]);
    for (const PosedShot& shot : shots) {
      T_C0T.emplace_back(shot.T_C0T);
      inset_m.emplace_back(shot.inset_m[0], shot.inset_m[1]);
    }
  }
  void store(CameraRig& rig, std::vector<PosedShot>& shots) const {
    for (int c = 0; c < rig.cameras; ++c) set_lens(lens[c].data(), rig.camera[c]);
    rig.T_C1C0 = T_C1C0.transform();
    for (size_t i = 0; i < shots.size(); ++i) {
      shots[i].T_C0T = T_C0T[i].transform();
      for (int c = 0; c < 2; ++c) shots[i].inset_m[c] = inset_m[i][c];
    }
  }
};

// Calls visit(camera, corner, error) for each corner that the lens can see.
template <class Visit>
void for_each_corner(const Target& target, const CameraRig& rig,
                     const std::vector<PosedShot>& shots, Visit&& visit) {
  for (size_t i = 0; i < shots.size(); ++i) {
    for (int c = 0; c < rig.cameras; ++c) {
      const SE3 T_CT = c == 0 ? shots[i].T_C0T : rig.T_C1C0 * shots[i].T_C0T;
      for (const Corner& corner : shots[i].shot.view[c].corners) {
        Vec2 uv;
        const Vec3 p_T = target.p_T(corner.id) - shots[i].inset_m[c] * target.outward_T(corner.id);
        if (!rig.camera[c].project(T_CT * p_T, uv)) continue;
        visit(i, c, corner, Vec2(uv - corner.uv));
      }
    }
  }
}

double robust_sigma(const Target& target, const CameraRig& rig,
                    const std::vector<PosedShot>& shots) {
  std::vector<double> errors;
  for_each_corner(target, rig, shots, [&](size_t, int, const Corner&, const Vec2& e) {
    errors.push_back(std::abs(e.x()));
    errors.push_back(std::abs(e.y()));
  });
  if (errors.empty()) return kStartSigma_px;
  const auto middle = errors.begin() + long(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return std::max(1e-4, 1.4826 * *middle);
}

// Residuals in px; corners beyond the gate are left out.
void build(const Target& target, bool bent, const CameraRig& rig,
           const std::vector<PosedShot>& shots, double gate_px, double sigma_px, Unknowns& x,
           ceres::Problem& problem) {
  auto* const loss = new ceres::CauchyLoss(kCauchy_sigmas * sigma_px);
  auto* const manifold = new RotationManifold;
  Target flat = target;
  flat.shift_T.clear();
  std::vector<char> used(shots.size(), 0);
  bool right = false;
  for_each_corner(target, rig, shots, [&](size_t i, int c, const Corner& corner, const Vec2& e) {
    if (!(e.norm() < gate_px)) return;
    double* const shift = x.shift_T[size_t(corner.id / 4)].data();
    const Sighting sighting{rig.camera[c].model, flat.p_T(corner.id), flat.outward_T(corner.id),
                            corner.uv};
    Pose& pose = x.T_C0T[i];
    used[i] = 1;
    if (c == 0) {
      problem.AddResidualBlock(new LeftCorner(sighting), loss, x.lens[0].data(), &x.inset_m[i][0],
                               pose.rotation.q, pose.p.data(), shift);
    } else {
      right = true;
      problem.AddResidualBlock(new RightCorner(sighting), loss, x.lens[1].data(), &x.inset_m[i][1],
                               pose.rotation.q, pose.p.data(), shift, x.T_C1C0.rotation.q,
                               x.T_C1C0.p.data());
    }
  });
  for (size_t i = 0; i < shots.size(); ++i) {
    if (used[i] != 0) problem.SetManifold(x.T_C0T[i].rotation.q, manifold);
  }
  if (right) problem.SetManifold(x.T_C1C0.rotation.q, manifold);
  const Eigen::Map<const Vec3> tag_sigma(kTagSigma_m);
  for (Vec3& shift : x.shift_T) {
    if (!problem.HasParameterBlock(shift.data())) continue;
    // Residuals are pixels here.
    problem.AddResidualBlock(new PriorCost(Vec3::Zero(), tag_sigma / sigma_px), nullptr,
                             shift.data());
    if (!bent) problem.SetParameterBlockConstant(shift.data());
  }
}

void summarize(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& shots,
               Adjustment& out) {
  double squares[2] = {0, 0};
  out.outliers = 0;
  out.corners[0] = out.corners[1] = 0;
  for_each_corner(target, rig, shots, [&](size_t, int c, const Corner&, const Vec2& e) {
    if (e.norm() > kOutlier_sigmas * out.sigma_px) {
      ++out.outliers;
      return;
    }
    squares[c] += e.squaredNorm();
    ++out.corners[c];
  });
  for (int c = 0; c < rig.cameras; ++c) {
    out.rms_px[c] = out.corners[c] > 0 ? std::sqrt(squares[c] / double(2 * out.corners[c])) : 0;
  }
}

}  // namespace

bool adjust(Target& target, bool bent, CameraRig& rig, std::vector<PosedShot>& shots,
            Adjustment& out) {
  Unknowns x(target, rig, shots);
  double sigma_px = kStartSigma_px, gate_px = 1e9;
  for (int round = 0; round < kRounds; ++round) {
    ceres::Problem problem;
    build(target, bent, rig, shots, gate_px, sigma_px, x, problem);
    if (problem.NumResidualBlocks() == 0) return false;
    ceres::Solver::Summary summary;
    ceres::Solve(solver_options(kStepsMax), &problem, &summary);
    if (!summary.IsSolutionUsable()) return false;
    x.store(rig, shots);
    target.shift_T = x.shift_T;
    sigma_px = robust_sigma(target, rig, shots);
    gate_px = kOutlier_sigmas * std::max(sigma_px, 0.02);
    if (round + 1 < kRounds) continue;
    std::vector<double*> blocks = {x.lens[0].data()};
    if (rig.cameras == 2) {
      blocks.insert(blocks.end(), {x.lens[1].data(), x.T_C1C0.rotation.q, x.T_C1C0.p.data()});
    }
    if (!problem.HasParameterBlock(blocks.back())) return false;
    if (!marginal_covariance(problem, blocks, out.covariance)) return false;
    out.covariance *= sigma_px * sigma_px;
  }
  out.sigma_px = sigma_px;
  summarize(target, rig, shots, out);
  return true;
}

}  // namespace pirvs::tools
