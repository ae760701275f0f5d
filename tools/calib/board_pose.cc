#include "tools/calib/board_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "core/math/so3.h"
#include "tools/calib/tag_image.h"

namespace pirvs::tools {
namespace {

constexpr size_t kTagsMin = 6;
constexpr int kStepsMax = 15;
constexpr double kHuber_px = 2;  // at the start lenses are wrong by more than noise

// The plane's homography on rays: [r1 r2 t] up to scale.
bool start_pose(const Camera& camera, const Target& target, const View& view, SE3& T_CT) {
  using Mat99 = Eigen::Matrix<double, 9, 9>;
  const Vec3 middle = target.middle_T();
  const double size = target.diagonal_m();
  Mat99 A = Mat99::Zero();
  size_t used = 0;
  Vec3 sum = Vec3::Zero();
  for (const SeenTag& tag : view.tags) {
    Vec3 ray;
    if (!camera.unproject(tag.uv, ray)) continue;
    const Vec3 q = (target.tag_T(tag.id) - middle) / size + Vec3(0, 0, 1);
    Eigen::Matrix<double, 3, 9> rows;  // ray x (H q) = 0
    rows << q.x() * skew(ray), q.y() * skew(ray), skew(ray);
    A += rows.transpose() * rows;
    sum += ray;
    ++used;
  }
  if (used < kTagsMin) return false;
  const Eigen::SelfAdjointEigenSolver<Mat99> eigen(A);
  constexpr double kDegenerate = 1e-9;  // tags on a line leave more than one solution
  if (!(eigen.eigenvalues()[1] > kDegenerate)) return false;
  Mat3 H = Eigen::Map<const Mat3>(eigen.eigenvectors().col(0).data());
  if (H.col(2).dot(sum) < 0) H = -H;
  const double scale = std::sqrt(H.col(0).norm() * H.col(1).norm());
  if (!(scale > 0)) return false;
  Mat3 R;
  R << H.col(0) / H.col(0).norm(), H.col(1) / H.col(1).norm(), Vec3::Zero();
  R.col(2) = R.col(0).cross(R.col(1)).normalized();
  R.col(1) = R.col(2).cross(R.col(0)).normalized();
  T_CT.R = R;
  T_CT.p = H.col(2) / scale * size - R * middle;
  return true;
}

struct Normal {
  Mat6 A = Mat6::Zero();
  Vec6 b = Vec6::Zero();
  double cost = 0;     // Huber
  double squares = 0;  // px^2
  size_t used = 0;
};

// By theta of R Exp(theta) and p. Tags that the lens cannot see at this pose are left out.
Normal linearize(const Camera& camera, const Target& target, const View& view,
                 const BoardPose& pose) {
  Normal out;
  for (const SeenTag& tag : view.tags) {
    TagImage image;
    if (!project_tag(camera, target, pose.T_CT, tag.id, image)) continue;
    const Vec2 r = tag.uv - image.uv;
    const double e = r.norm();
    const double weight = e > kHuber_px ? kHuber_px / e : 1;
    out.A += weight * image.by_pose.transpose() * image.by_pose;
    out.b += weight * image.by_pose.transpose() * r;
    out.cost += e > kHuber_px ? 2 * kHuber_px * e - kHuber_px * kHuber_px : e * e;
    out.squares += e * e;
    ++out.used;
  }
  return out;
}

}  // namespace

bool refine_pose(const Camera& camera, const Target& target, const View& view, BoardPose& pose) {
  Normal at = linearize(camera, target, view, pose);
  double damping = 1e-4;
  for (int i = 0; i < kStepsMax && at.used >= kTagsMin; ++i) {
    Mat6 A = at.A;
    A.diagonal() *= 1 + damping;
    const Vec6 step = A.ldlt().solve(at.b);
    if (!step.allFinite()) return false;
    BoardPose moved = pose;
    moved.T_CT.R = pose.T_CT.R * so3_exp(step.head<3>());
    moved.T_CT.p += step.tail<3>();
    const Normal next = linearize(camera, target, view, moved);
    if (next.used >= at.used && next.cost <= at.cost) {
      const bool done = at.cost - next.cost < 1e-9 * at.cost;
      pose = moved;
      at = next;
      damping /= 10;
      if (done) break;
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
  }
  pose.rms_px = at.used > 0 ? std::sqrt(at.squares / double(2 * at.used)) : 0;
  return at.used >= kTagsMin && pose.T_CT.p.allFinite();
}

bool find_pose(const Camera& camera, const Target& target, const View& view, BoardPose& out) {
  return view.tags.size() >= kTagsMin && start_pose(camera, target, view, out.T_CT) &&
         refine_pose(camera, target, view, out);
}

}  // namespace pirvs::tools
