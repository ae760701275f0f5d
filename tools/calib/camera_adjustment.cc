#include "tools/calib/camera_adjustment.h"

#include <ceres/loss_function.h>
#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <cmath>

#include "core/math/so3.h"
#include "tools/calib/solver.h"
#include "tools/calib/tag_image.h"

namespace pirvs::tools {
namespace {

constexpr double kOutlier_sigmas = 5;
constexpr double kCauchy_sigmas = 3;
constexpr double kStartSigma_px = 1;
constexpr int kRounds = 4;
constexpr int kStepsMax = 40;

using Mat24 = Eigen::Matrix<double, 2, 4, Eigen::RowMajor>;
using Row23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using Row28 = Eigen::Matrix<double, 2, kLensSize, Eigen::RowMajor>;

struct Sighting {
  const Camera& camera;  // all but the lens
  const Target& flat;
  SeenTag tag;
};

// r = h(T_CT (p_T + shift)) - uv; moving the tag is moving the board.
bool residual(const Sighting& sighting, const double* lens, SE3 T_CT, const double* shift,
              double* r, TagImage& image) {
  Camera camera = sighting.camera;
  set_lens(lens, camera);
  T_CT.p += T_CT.R * Eigen::Map<const Vec3>(shift);
  if (!project_tag(camera, sighting.flat, T_CT, sighting.tag.id, image)) return false;
  // Of the board's own rotation, about its origin.
  image.by_pose.leftCols<3>() -= image.by_shift * skew(Eigen::Map<const Vec3>(shift));
  Eigen::Map<Vec2>(r).noalias() = image.uv - sighting.tag.uv;
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

SE3 transform_of(const double* q, const double* p) {
  return {matrix_of(q), Eigen::Map<const Vec3>(p)};
}

// Unknowns: lens, q and p of T_C0T, shift of the tag.
class LeftTag final : public ceres::SizedCostFunction<2, kLensSize, 4, 3, 3> {
 public:
  explicit LeftTag(const Sighting& sighting) : sighting_(sighting) {}

  bool Evaluate(double const* const* x, double* r, double** jacobians) const override {
    TagImage image;
    if (!residual(sighting_, x[0], transform_of(x[1], x[2]), x[3], r, image)) return false;
    if (jacobians == nullptr) return true;
    put<Row28>(jacobians[0], image.by_lens);
    put_rotation(jacobians[1], image.by_pose.leftCols<3>());
    put<Row23>(jacobians[2], image.by_pose.rightCols<3>());
    put<Row23>(jacobians[3], image.by_shift);
    return true;
  }

 private:
  Sighting sighting_;
};

// Unknowns: lens, q and p of T_C0T, shift of the tag, q and p of T_C1C0.
class RightTag final : public ceres::SizedCostFunction<2, kLensSize, 4, 3, 3, 4, 3> {
 public:
  explicit RightTag(const Sighting& sighting) : sighting_(sighting) {}

  bool Evaluate(double const* const* x, double* r, double** jacobians) const override {
    const SE3 T_C0T = transform_of(x[1], x[2]), T_C1C0 = transform_of(x[4], x[5]);
    TagImage image;
    if (!residual(sighting_, x[0], T_C1C0 * T_C0T, x[3], r, image)) return false;
    if (jacobians == nullptr) return true;
    const StereoParts parts = stereo_parts(image, T_C1C0.R, T_C0T);
    put<Row28>(jacobians[0], image.by_lens);
    put_rotation(jacobians[1], image.by_pose.leftCols<3>());
    put<Row23>(jacobians[2], parts.by_p_C0T);
    put<Row23>(jacobians[3], image.by_shift);
    put_rotation(jacobians[4], parts.by_theta_C1C0);
    put<Row23>(jacobians[5], image.by_pose.rightCols<3>());
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
  std::vector<Vec3> shift_T;

  Unknowns(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& shots)
      : T_C1C0(rig.T_C1C0), shift_T(target.shift_T) {
    shift_T.resize(size_t(target.tags()), Vec3::Zero());
    for (int c = 0; c < 2; ++c) lens[c] = lens_of(rig.camera[c]);
    for (const PosedShot& shot : shots) {
      T_C0T.emplace_back(shot.T_C0T);
    }
  }
  void store(CameraRig& rig, std::vector<PosedShot>& shots) const {
    for (int c = 0; c < rig.cameras; ++c) set_lens(lens[c].data(), rig.camera[c]);
    rig.T_C1C0 = T_C1C0.transform();
    for (size_t i = 0; i < shots.size(); ++i) {
      shots[i].T_C0T = T_C0T[i].transform();
    }
  }
};

// Calls visit(shot, camera, tag, error) for each tag that the lens can see.
template <class Visit>
void for_each_tag(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& shots,
                  Visit&& visit) {
  for (size_t i = 0; i < shots.size(); ++i) {
    for (int c = 0; c < rig.cameras; ++c) {
      const SE3 T_CT = c == 0 ? shots[i].T_C0T : rig.T_C1C0 * shots[i].T_C0T;
      for (const SeenTag& tag : shots[i].shot.view[c].tags) {
        TagImage image;
        if (!project_tag(rig.camera[c], target, T_CT, tag.id, image)) continue;
        visit(i, c, tag, Vec2(image.uv - tag.uv));
      }
    }
  }
}

double robust_sigma(const Target& target, const CameraRig& rig,
                    const std::vector<PosedShot>& shots) {
  std::vector<double> errors;
  for_each_tag(target, rig, shots, [&](size_t, int, const SeenTag&, const Vec2& e) {
    errors.push_back(std::abs(e.x()));
    errors.push_back(std::abs(e.y()));
  });
  if (errors.empty()) return kStartSigma_px;
  const auto middle = errors.begin() + long(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return std::max(1e-4, 1.4826 * *middle);
}

// Residuals in px; tags beyond the gate are left out. The problem refers to all but gate and sigma.
void build(const Target& target, const Target& flat, bool bent, const CameraRig& rig,
           const std::vector<PosedShot>& shots, double gate_px, double sigma_px, Unknowns& x,
           ceres::Problem& problem) {
  auto* const loss = new ceres::CauchyLoss(kCauchy_sigmas * sigma_px);
  auto* const manifold = new RotationManifold;
  std::vector<char> used(shots.size(), 0);
  bool right = false;
  for_each_tag(target, rig, shots, [&](size_t i, int c, const SeenTag& tag, const Vec2& e) {
    if (!(e.norm() < gate_px)) return;
    double* const shift = x.shift_T[size_t(tag.id)].data();
    const Sighting sighting{rig.camera[c], flat, tag};
    Pose& pose = x.T_C0T[i];
    used[i] = 1;
    if (c == 0) {
      problem.AddResidualBlock(new LeftTag(sighting), loss, x.lens[0].data(), pose.rotation.q,
                               pose.p.data(), shift);
    } else {
      right = true;
      problem.AddResidualBlock(new RightTag(sighting), loss, x.lens[1].data(), pose.rotation.q,
                               pose.p.data(), shift, x.T_C1C0.rotation.q, x.T_C1C0.p.data());
    }
  });
  for (size_t i = 0; i < shots.size(); ++i) {
    if (used[i] != 0) problem.SetManifold(x.T_C0T[i].rotation.q, manifold);
  }
  if (right) problem.SetManifold(x.T_C1C0.rotation.q, manifold);
  // Residuals are pixels here.
  const Vec3 tag_sigma = tag_prior_m(flat) / sigma_px;
  for (Vec3& shift : x.shift_T) {
    if (!problem.HasParameterBlock(shift.data())) continue;
    problem.AddResidualBlock(new PriorCost(Vec3::Zero(), tag_sigma), nullptr, shift.data());
    if (!bent) problem.SetParameterBlockConstant(shift.data());
  }
}

void summarize(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& shots,
               Adjustment& out) {
  double squares[2] = {0, 0};
  out.outliers = 0;
  out.tags[0] = out.tags[1] = 0;
  for_each_tag(target, rig, shots, [&](size_t, int c, const SeenTag&, const Vec2& e) {
    if (e.norm() > kOutlier_sigmas * out.sigma_px) {
      ++out.outliers;
      return;
    }
    squares[c] += e.squaredNorm();
    ++out.tags[c];
  });
  for (int c = 0; c < rig.cameras; ++c) {
    out.rms_px[c] = out.tags[c] > 0 ? std::sqrt(squares[c] / double(2 * out.tags[c])) : 0;
  }
}

// A tag that no shot shows keeps its prior.
bool covariances(const CameraRig& rig, double sigma_px, const Target& flat, Unknowns& x,
                 ceres::Problem& problem, Adjustment& out) {
  std::vector<double*> blocks = {x.lens[0].data()};
  if (rig.cameras == 2) {
    blocks.insert(blocks.end(), {x.lens[1].data(), x.T_C1C0.rotation.q, x.T_C1C0.p.data()});
  }
  if (!problem.HasParameterBlock(blocks.back())) return false;
  std::vector<Eigen::Index> at;
  for (size_t tag = 0; tag < x.shift_T.size(); ++tag) {
    if (!problem.HasParameterBlock(x.shift_T[tag].data())) continue;
    blocks.push_back(x.shift_T[tag].data());
    for (int i = 0; i < 3; ++i) at.push_back(Eigen::Index(3 * tag) + i);
  }
  Eigen::MatrixXd P;
  if (!marginal_covariance(problem, blocks, P)) return false;
  P *= sigma_px * sigma_px;
  const int n = rig.unknowns();
  out.covariance = P.topLeftCorner(n, n);
  const Eigen::VectorXd all = tag_prior_m(flat).cwiseAbs2().replicate(flat.tags(), 1);
  out.board_covariance = all.asDiagonal();
  for (size_t i = 0; i < at.size(); ++i) {
    for (size_t j = 0; j < at.size(); ++j) {
      out.board_covariance(at[i], at[j]) = P(n + Eigen::Index(i), n + Eigen::Index(j));
    }
  }
  return true;
}

}  // namespace

Vec3 tag_prior_m(const Target& target) {
  constexpr double kInPlane = 0.5e-3, kOutOfPlane = 2e-3;
  return target.diagonal_m() * Vec3(kInPlane, kInPlane, kOutOfPlane);
}

bool adjust(Target& target, bool bent, CameraRig& rig, std::vector<PosedShot>& shots,
            Adjustment& out) {
  Unknowns x(target, rig, shots);
  Target flat = target;
  flat.shift_T.clear();
  double sigma_px = kStartSigma_px, gate_px = 1e9;
  for (int round = 0; round < kRounds; ++round) {
    ceres::Problem problem;
    build(target, flat, bent, rig, shots, gate_px, sigma_px, x, problem);
    if (problem.NumResidualBlocks() == 0) return false;
    ceres::Solver::Summary summary;
    ceres::Solve(solver_options(kStepsMax), &problem, &summary);
    if (!summary.IsSolutionUsable()) return false;
    x.store(rig, shots);
    target.shift_T = x.shift_T;
    sigma_px = robust_sigma(target, rig, shots);
    gate_px = kOutlier_sigmas * std::max(sigma_px, 0.02);
    if (bent && round + 1 == kRounds && !covariances(rig, sigma_px, flat, x, problem, out)) {
      return false;
    }
  }
  out.sigma_px = sigma_px;
  summarize(target, rig, shots, out);
  return true;
}

}  // namespace pirvs::tools
