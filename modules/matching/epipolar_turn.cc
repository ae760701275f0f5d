#include "modules/matching/epipolar_turn.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/math/random.h"
#include "core/math/square.h"
#include "core/store/fixed_vector.h"
#include "modules/frontend/track.h"

namespace pirvs {
namespace {

constexpr double kMatch_px = 0.5, kStray_px = 2;  // of a match; from where on it is rather a stray
constexpr double kMemory = 400;                   // matches
constexpr double kBegin_rad = 0.1;
constexpr double kMatchesMin = 40;
constexpr double kSquint_rad = 7e-3, kTurned_rad = 5e-3;  // from which on they disagree
constexpr double kShared = 3;  // a lens that fits badly: residuals are not independent
constexpr double kSure = 5;    // sigmas

}  // namespace

void EpipolarTurn::configure(const Camera& c0, const Camera& c1) {
  *this = {};
  T_C1C0_ = c1.T_BC.inverse() * c0.T_BC;
  R_BC1_ = c1.T_BC.R;
  pixel_rad_ = 1 / c1.fx;
}

bool EpipolarTurn::miss(const Vec3& f_C0, const Vec3& f_C1, Miss& out) const {
  const Vec3 ray = T_C1C0_.R * f_C0;
  const Vec3& p = T_C1C0_.p;
  const double length = p.cross(ray).norm();
  if (length < 0.1 * p.norm()) return false;  // along the baseline: a turn leaves it in its plane
  out.off_rad = f_C1.dot(p.cross(ray)) / length;
  out.J = (p.dot(ray) * f_C1 - f_C1.dot(ray) * p) / length;
  return true;
}

void EpipolarTurn::add(const Vec3& f_C0, const Vec3& f_C1) {
  Miss m;
  if (!miss(f_C0, f_C1, m)) return;
  const double stray = (m.off_rad + m.J.dot(turn_C1_)) / (kStray_px * pixel_rad_);
  const double weight = 1 / (square(kMatch_px * pixel_rad_) * square(1 + square(stray)));
  const double kept = 1 - 1 / kMemory;
  information_ = kept * information_ + weight * m.J * m.J.transpose();
  score_ = kept * score_ - weight * m.off_rad * m.J;
  // Strays vote against: where they are many, no turn explains what is seen.
  matches_ = std::max(0.0, kept * matches_ + (square(stray) < 1 ? 1 : -1));
  turn_C1_ = covariance() * score_;
}

void EpipolarTurn::add_looks(const Look* looks, int count) {
  constexpr int kTries = 100, kSample = 3;
  constexpr size_t kLooksMin = 12;
  FixedVector<Miss, kTracksMax> misses;
  for (int i = 0; i < count && !misses.full(); ++i) {
    Miss m;
    if (miss(looks[i].f_C0, looks[i].f_C1, m)) (void)misses.push_back(m);
  }
  const size_t n = misses.size();
  if (n < kLooksMin) return;
  const auto fits = [&](const Miss& m, const Vec3& turn) {
    return std::abs(m.off_rad + m.J.dot(turn)) < kStray_px * pixel_rad_;
  };
  RandomGenerator random;
  Vec3 best = Vec3::Zero();
  size_t best_fits = 0;
  for (int i = 0; i <= kTries; ++i) {
    Vec3 turn = Vec3::Zero();  // the first guess: as calibrated
    if (i > 0) {
      Mat3 H = square(kMatch_px * pixel_rad_ / kBegin_rad) * Mat3::Identity();
      Vec3 b = Vec3::Zero();
      for (int k = 0; k < kSample; ++k) {
        const Miss& m = misses[random.below(static_cast<uint32_t>(n))];
        H += m.J * m.J.transpose();
        b -= m.off_rad * m.J;
      }
      turn = H.inverse() * b;
    }
    size_t fitting = 0;
    for (const Miss& m : misses) fitting += fits(m, turn) ? 1 : 0;
    if (fitting <= best_fits) continue;
    best_fits = fitting;
    best = turn;
  }
  if (2 * best_fits < n || best_fits < kLooksMin) return;
  for (const Miss& m : misses) {
    if (!fits(m, best)) continue;
    const double weight = 1 / square(kMatch_px * pixel_rad_);
    information_ += weight * m.J * m.J.transpose();
    score_ -= weight * m.off_rad * m.J;
  }
  matches_ = std::max(matches_, kMatchesMin);  // chance does not make so many agree
  turn_C1_ = covariance() * score_;
}

Mat3 EpipolarTurn::covariance() const {
  return (information_ + Mat3::Identity() / square(kBegin_rad)).inverse();
}

bool EpipolarTurn::disagrees() const {
  if (matches_ < kMatchesMin) return false;
  const Mat3 cov_C1 = covariance();
  const Vec3 along = T_C1C0_.p.normalized();
  const Vec3 squint = along.cross(Vec3::UnitZ()).normalized();
  const auto off = [&](const Vec3& axis, double limit_rad) {
    const double turn_rad = std::abs(axis.dot(turn_C1_));
    const double sigma_rad = kShared * std::sqrt(axis.dot(cov_C1 * axis));
    return turn_rad > limit_rad && turn_rad > kSure * sigma_rad;
  };
  return off(along, kTurned_rad) || off(squint.cross(along), kTurned_rad) ||
         off(squint, kSquint_rad);
}

void EpipolarTurn::forget() {
  constexpr double kLeft = 0.05;
  information_ *= kLeft;
  score_ *= kLeft;
  matches_ *= kLeft;
}

}  // namespace pirvs
