#include "tools/dataset/calibration/lens.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

namespace pirvs::tools {
namespace {

constexpr double kDepthMin = 1e-6;

// A sensor that is tilted by two angles about its x and y axes.
Vec2 tilted(double tau_x, double tau_y, const Vec2& m) {
  if (tau_x == 0 && tau_y == 0) return m;
  const double cx = std::cos(tau_x), sx = std::sin(tau_x);
  const double cy = std::cos(tau_y), sy = std::sin(tau_y);
  Mat3 R;
  R << cy, sx * sy, -sy * cx, 0, cx, sx, sy, -cy * sx, cy * cx;
  const Vec3 p = R * Vec3(m.x(), m.y(), 1);
  return {(R(2, 2) * p.x() - R(0, 2) * p.z()) / p.z(), (R(2, 2) * p.y() - R(1, 2) * p.z()) / p.z()};
}

Vec2 radtan(const std::array<double, 14>& d, const Vec2& m) {
  const double x = m.x(), y = m.y(), u = m.squaredNorm();
  const double radial =
      (1 + u * (d[0] + u * (d[1] + u * d[4]))) / (1 + u * (d[5] + u * (d[6] + u * d[7])));
  return tilted(d[12], d[13],
                {x * radial + 2 * d[2] * x * y + d[3] * (u + 2 * x * x) + u * (d[8] + u * d[9]),
                 y * radial + d[2] * (u + 2 * y * y) + 2 * d[3] * x * y + u * (d[10] + u * d[11])});
}

// From the plane at z = 1, or what a projection has instead of it, to the distorted one.
Vec2 distorted(const Lens& lens, const Vec2& m) {
  const double r = m.norm();
  if (lens.distortion == Distortion::kRadtan) return radtan(lens.d, m);
  if (r < 1e-12) return m;
  if (lens.distortion == Distortion::kFov) {
    const double w = lens.d[0];
    return std::abs(w) < 1e-6 ? m : Vec2(m * (std::atan(2 * r * std::tan(w / 2)) / (w * r)));
  }
  if (lens.distortion == Distortion::kEquidistant) {
    const double theta = std::atan(r), u = theta * theta;
    const double k = 1 + u * (lens.d[0] + u * (lens.d[1] + u * (lens.d[2] + u * lens.d[3])));
    return m * (theta * k / r);
  }
  return m;
}

// Where the ray of a bent plane is measured: x, y over this.
double denominator(const Lens& lens, const Vec3& p) {
  const double x2y2 = p.x() * p.x() + p.y() * p.y();
  const double norm = p.norm();
  switch (lens.projection) {
    case Projection::kOmni:
      return p.z() + lens.a * norm;
    case Projection::kDoubleSphere: {
      const double z1 = lens.a * norm + p.z();
      return lens.b * std::sqrt(x2y2 + z1 * z1) + (1 - lens.b) * z1;
    }
    case Projection::kEucm:
      return lens.a * std::sqrt(lens.b * x2y2 + p.z() * p.z()) + (1 - lens.a) * p.z();
    case Projection::kPinhole:
      break;
  }
  return p.z();
}

Vec3 ray(const Vec2& angles) {
  const double theta = angles.norm();
  const double s = theta > 1e-9 ? std::sin(theta) / theta : 1;
  return {angles.x() * s, angles.y() * s, std::cos(theta)};
}

// Newton's step towards the pixel; false beyond a fold of the model.
bool step_to(const Lens& lens, const Vec2& uv, Vec2& angles) {
  constexpr double kStep = 1e-6, kConverged_px = 1e-7;
  constexpr int kStepsMax = 20;
  for (int i = 0; i < kStepsMax; ++i) {
    Vec2 at, px, py, mx, my;
    const bool good = lens.project(ray(angles), at) &&
                      lens.project(ray(angles + Vec2(kStep, 0)), px) &&
                      lens.project(ray(angles - Vec2(kStep, 0)), mx) &&
                      lens.project(ray(angles + Vec2(0, kStep)), py) &&
                      lens.project(ray(angles - Vec2(0, kStep)), my);
    if (!good) return false;
    Eigen::Matrix2d J;
    J << (px - mx) / (2 * kStep), (py - my) / (2 * kStep);
    if (!(J.determinant() > 0) || !(J(0, 0) + J(1, 1) > 0)) return false;
    const Vec2 error = uv - at;
    if (error.norm() < kConverged_px) return angles.norm() < M_PI;
    angles += J.inverse() * error;
    if (!angles.allFinite()) return false;
  }
  return false;
}

// The ray of a pixel, found along the line from the principal point, so that it is that of the
// model's first branch.
bool unproject(const Lens& lens, const Vec2& uv, Vec3& out) {
  constexpr double kStride_px = 16, kStrides_max = 4096;  // a principal point far off is nonsense
  const Vec2 centre(lens.cx, lens.cy);
  const double strides = (uv - centre).norm() / kStride_px;
  if (!(strides < kStrides_max)) return false;
  const int steps = 1 + int(strides);
  Vec2 angles = Vec2::Zero();
  for (int i = 1; i <= steps; ++i) {
    if (!step_to(lens, centre + (uv - centre) * (double(i) / steps), angles)) return false;
  }
  out = ray(angles);
  return true;
}

struct Sight {
  Vec3 ray;
  Vec2 uv;
  bool matters;  // not in a corner
  double weight = 1;
};

std::vector<Sight> sights_of(const Lens& lens) {
  constexpr int kAcross = 20;
  const double stride = std::max(lens.width, lens.height) / double(kAcross);
  const Vec2 half((lens.width - 1) / 2.0, (lens.height - 1) / 2.0);
  std::vector<Sight> out;
  const int columns = std::max(4, int(lens.width / stride)),
            rows = std::max(4, int(lens.height / stride));
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j <= columns; ++j) {
      Sight sight;
      sight.uv = Vec2(2 * half.x() * j / columns, 2 * half.y() * i / rows);
      if (!unproject(lens, sight.uv, sight.ray)) continue;
      sight.matters = (sight.uv - half).cwiseQuotient(half).norm() <= 1.0 + 1e-9;
      out.push_back(sight);
    }
  }
  return out;
}

using Numbers = Eigen::Matrix<double, 8, 1>;

Camera camera_of(CameraModel model, const Lens& lens, const Numbers& x) {
  Camera camera;
  camera.model = model;
  camera.width = lens.width;
  camera.height = lens.height;
  camera.fx = x[0], camera.fy = x[1], camera.cx = x[2], camera.cy = x[3];
  for (int i = 0; i < 4; ++i) camera.d[i] = x[4 + i];
  return camera;
}

// What an error in a corner counts: few corners are found there, and those that are far off are
// gated.
constexpr double kCorner = 1.0 / 30;

// Weighted sum of squares; infinite where the camera does not see a ray that matters.
double cost(const Camera& camera, const std::vector<Sight>& sights, std::vector<Vec2>& errors) {
  double sum = 0;
  for (size_t i = 0; i < sights.size(); ++i) {
    Vec2 uv;
    if (!camera.project(sights[i].ray, uv)) return INFINITY;
    errors[i] = (uv - sights[i].uv) * sights[i].weight;
    sum += errors[i].squaredNorm();
  }
  return sum;
}

// Levenberg and Marquardt, with numeric derivatives.
Numbers least_squares(CameraModel model, const Lens& lens, const std::vector<Sight>& sights,
                      Numbers x) {
  constexpr int kRoundsMax = 40;
  constexpr double kEnough = 1e-12;
  std::vector<Vec2> errors(sights.size()), plus(sights.size()), minus(sights.size());
  double sum = cost(camera_of(model, lens, x), sights, errors);
  double damping = 1e-4;
  for (int round = 0; round < kRoundsMax && std::isfinite(sum); ++round) {
    Eigen::MatrixXd J(2 * Eigen::Index(sights.size()), 8);
    Eigen::VectorXd r(J.rows());
    for (int k = 0; k < 8; ++k) {
      const double step = k < 4 ? 1e-3 : 1e-7;
      Numbers up = x, down = x;
      up[k] += step;
      down[k] -= step;
      const bool good = std::isfinite(cost(camera_of(model, lens, up), sights, plus)) &&
                        std::isfinite(cost(camera_of(model, lens, down), sights, minus));
      for (size_t i = 0; i < sights.size(); ++i) {
        const Vec2 slope = good ? Vec2((plus[i] - minus[i]) / (2 * step)) : Vec2(Vec2::Zero());
        J.block<2, 1>(2 * Eigen::Index(i), k) = slope;
        r.segment<2>(2 * Eigen::Index(i)) = errors[i];
      }
    }
    const Eigen::Matrix<double, 8, 8> A = J.transpose() * J;
    const Numbers b = J.transpose() * r;
    bool better = false;
    for (; !better && damping < 1e12; damping *= 10) {
      Eigen::Matrix<double, 8, 8> damped = A;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-12;
      const Numbers next = x - Numbers(damped.ldlt().solve(b));
      const double now =
          next.allFinite() ? cost(camera_of(model, lens, next), sights, plus) : INFINITY;
      if (!(now < sum)) continue;
      better = true;
      const bool enough = sum - now < kEnough * sum;
      x = next;
      sum = now;
      errors = plus;
      damping *= 0.01;
      if (enough) return x;
    }
    if (!better) break;
  }
  return x;
}

LensFit measured(const Camera& camera, const std::vector<Sight>& sights) {
  LensFit out;
  out.camera = camera;
  for (const Sight& sight : sights) {
    Vec2 uv;
    const double error = camera.project(sight.ray, uv) ? (uv - sight.uv).norm() : INFINITY;
    out.corner_px = std::max(out.corner_px, error);
    if (sight.matters) out.error_px = std::max(out.error_px, error);
  }
  if (sights.empty()) out.error_px = INFINITY;
  return out;
}

double worst(const LensFit& fit) { return std::max(fit.error_px, kCorner * fit.corner_px); }

// The least largest error, not the least sum of squares: what is far off weighs more, round by
// round (Lawson).
LensFit fitted(CameraModel model, const Lens& lens, std::vector<Sight> sights, Numbers x) {
  constexpr int kRounds = 8;
  constexpr double kWeight_min = 1e-3;
  for (Sight& sight : sights) sight.weight = sight.matters ? 1 : kCorner;
  LensFit best;
  best.error_px = INFINITY;
  for (int round = 0; round < kRounds; ++round) {
    x = least_squares(model, lens, sights, x);
    const LensFit now = measured(camera_of(model, lens, x), sights);
    if (worst(now) < worst(best)) best = now;
    if (!std::isfinite(worst(now))) break;
    for (Sight& sight : sights) {
      Vec2 uv;
      const double scale = sight.matters ? 1 : kCorner;
      const bool good = now.camera.project(sight.ray, uv);
      const double share = good ? scale * (uv - sight.uv).norm() / worst(now) : 1;
      sight.weight *= std::sqrt(std::max(kWeight_min, share));
    }
    double largest = 0;
    for (const Sight& sight : sights) largest = std::max(largest, sight.weight);
    for (Sight& sight : sights) sight.weight = std::max(kWeight_min, sight.weight / largest);
  }
  return best;
}

bool is_ours(const Lens& lens) {
  if (lens.projection != Projection::kPinhole) return false;
  if (lens.distortion == Distortion::kFov) return false;
  return lens.distortion != Distortion::kRadtan ||
         std::all_of(lens.d.begin() + 4, lens.d.end(), [](double k) { return k == 0; });
}

}  // namespace

bool Lens::project(const Vec3& p_C, Vec2& uv) const {
  // An equidistant lens sees past 90 degrees: the angle counts, not x / z.
  if (projection == Projection::kPinhole && distortion == Distortion::kEquidistant) {
    Numbers x;
    x << fx, fy, cx, cy, d[0], d[1], d[2], d[3];
    return camera_of(CameraModel::kKannalaBrandt, *this, x).project(p_C, uv);
  }
  const double scale = denominator(*this, p_C);
  if (!(scale > kDepthMin * p_C.norm())) return false;
  const Vec2 m = distorted(*this, Vec2(p_C.x() / scale, p_C.y() / scale));
  uv = Vec2(fx * m.x() + cx, fy * m.y() + cy);
  return uv.allFinite();
}

LensFit fit(const Lens& lens) {
  Numbers x;
  x << lens.fx, lens.fy, lens.cx, lens.cy, lens.d[0], lens.d[1], lens.d[2], lens.d[3];
  if (is_ours(lens)) {
    LensFit out;
    if (lens.distortion == Distortion::kNone) x.tail<4>().setZero();
    out.camera =
        camera_of(lens.distortion == Distortion::kEquidistant ? CameraModel::kKannalaBrandt
                                                              : CameraModel::kPinholeRadtan,
                  lens, x);
    out.exact = true;
    return out;
  }
  const std::vector<Sight> sights = sights_of(lens);
  constexpr double kNarrow = 0.05;  // z of a ray that a plane at z = 1 still holds well
  const bool narrow =
      std::all_of(sights.begin(), sights.end(), [](const Sight& s) { return s.ray.z() > kNarrow; });
  Vec2 centre, right, down;
  constexpr double kTurn = 1e-4;
  const bool axis = lens.project(Vec3::UnitZ(), centre) && lens.project(Vec3(kTurn, 0, 1), right) &&
                    lens.project(Vec3(0, kTurn, 1), down);
  if (!axis) return measured(camera_of(CameraModel::kKannalaBrandt, lens, x), {});
  x << (right - centre).x() / kTurn, (down - centre).y() / kTurn, lens.cx, lens.cy, 0, 0, 0, 0;
  const LensFit fisheye = fitted(CameraModel::kKannalaBrandt, lens, sights, x);
  if (!narrow) return fisheye;
  const LensFit radtan = fitted(CameraModel::kPinholeRadtan, lens, sights, x);
  return worst(radtan) < worst(fisheye) ? radtan : fisheye;
}

std::vector<Vec3> rays_of(const Lens& lens) {
  const int width = lens.width, height = lens.height;
  const Vec2 none(NAN, NAN);
  std::vector<Vec2> angles(size_t(width) * size_t(height), none);
  const auto at = [&](int x, int y) -> Vec2& {
    return angles[size_t(y) * size_t(width) + size_t(x)];
  };
  // From the principal point outwards, each pixel from its neighbour, so that it is on the model's
  // first branch.
  const auto find = [&](int x, int y, Vec2 from) {
    if (from.allFinite() && step_to(lens, Vec2(x, y), from)) at(x, y) = from;
  };
  const int cx = std::clamp(int(std::lround(lens.cx)), 0, width - 1);
  const int cy = std::clamp(int(std::lround(lens.cy)), 0, height - 1);
  find(cx, cy, Vec2::Zero());
  for (int x = cx - 1; x >= 0; --x) find(x, cy, at(x + 1, cy));
  for (int x = cx + 1; x < width; ++x) find(x, cy, at(x - 1, cy));
  for (int x = 0; x < width; ++x) {
    for (int y = cy - 1; y >= 0; --y) find(x, y, at(x, y + 1));
    for (int y = cy + 1; y < height; ++y) find(x, y, at(x, y - 1));
  }
  std::vector<Vec3> out;
  out.reserve(angles.size());
  for (const Vec2& a : angles) out.push_back(a.allFinite() ? ray(a) : Vec3(Vec3::Zero()));
  return out;
}

}  // namespace pirvs::tools
