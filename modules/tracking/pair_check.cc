#include "modules/tracking/pair_check.h"

#include <algorithm>

#include <Eigen/LU>

#include "core/math/square.h"

namespace pirvs {
namespace {

constexpr double kLate_s = 2.5e-3, kTurned_rad = 5e-3;  // from which on they disagree
constexpr double kMemory_s = 3;
constexpr double kStep_s = 0.2;   // a longer gap counts as so much
constexpr double kStray_px = 15;  // a residual of a wrong match
constexpr double kRobust = 4;     // sigmas
constexpr double kBegin_s = 0.1, kBegin_rad = 0.1;
constexpr double kShared = 2;  // points are shared: residuals are not independent

}  // namespace

void PairCheck::begin_frame(TimeNs t, const Vec6& rate) {
  const double dt_s = std::clamp(to_seconds(t - t_), 0.0, kStep_s);
  for (Sum& sum : sum_) {
    sum.information *= 1 - dt_s / kMemory_s;
    sum.score *= 1 - dt_s / kMemory_s;
  }
  rate_ = rate;
  t_ = t;
}

void PairCheck::add(int camera, const Reprojection& m) {
  if (m.r.squaredNorm() > square(kStray_px)) return;
  Eigen::Matrix<double, 2, kN> G;
  G << m.J * rate_, m.J.leftCols<3>();
  const Mat2 R_inverse = m.R.inverse();
  const double weight = 1 / (1 + m.r.dot(R_inverse * m.r) / square(kRobust));
  const Eigen::Matrix<double, kN, 2> weighted = weight * G.transpose() * R_inverse;
  sum_[camera].information += weighted * G;
  sum_[camera].score += weighted * m.r;
}

bool PairCheck::Verdict::disagree() const {
  constexpr double kSure = 5;  // sigmas
  const auto off = [](double value, double sigma, double limit) {
    return std::abs(value) > limit && std::abs(value) > kSure * sigma;
  };
  return off(late_s, late_sigma_s, kLate_s) ||
         off(turn_B.norm(), turn_sigma_B.maxCoeff(), kTurned_rad);
}

bool PairCheck::judge(TimeNs t, double both_late_s, const Vec3& both_turn_B) {
  constexpr double kSure_s = 0.4;
  const Verdict pair = verdict();
  if (!pair.disagree()) {
    since_ = 0;
    return false;
  }
  if (since_ == 0) since_ = t;
  if (to_seconds(t - since_) < kSure_s) return false;
  leave_out(t, pair, both_late_s, both_turn_B);
  return true;
}

void PairCheck::leave_out(TimeNs t, const Verdict& pair, double both_late_s,
                          const Vec3& both_turn_B) {
  constexpr double kFirst_s = 10, kLongest_s = 160, kProbation_s = 5;
  const auto misfit = [&](double half) {
    return std::abs(both_late_s + half * pair.late_s) / kLate_s +
           (both_turn_B + half * pair.turn_B).norm() / kTurned_rad;
  };
  // What was left out and disagrees again stays out: the map stands on the other.
  const bool again = left_out_ != 0 && to_seconds(t - until_) < kProbation_s;
  if (!again) left_out_ = misfit(0.5) >= misfit(-0.5) ? 2 : 1;
  for_s_ = std::clamp(2 * for_s_, kFirst_s, kLongest_s);
  until_ = t + from_seconds(for_s_);
  since_ = 0;
  for (Sum& sum : sum_) sum = Sum{};
}

PairCheck::Verdict PairCheck::verdict() const {
  Eigen::Matrix<double, kN, 1> x = Eigen::Matrix<double, kN, 1>::Zero(), variance = x;
  double sign = -1;
  for (const Sum& sum : sum_) {
    Eigen::Matrix<double, kN, kN> all = sum.information;
    all(0, 0) += 1 / square(kBegin_s);
    all.diagonal().tail<3>().array() += 1 / square(kBegin_rad);
    const Eigen::Matrix<double, kN, kN> cov = all.inverse();
    x += sign * cov * sum.score;
    variance += square(kShared) * cov.diagonal();
    sign = 1;
  }
  return {x[0], std::sqrt(variance[0]), x.tail<3>(), variance.tail<3>().cwiseSqrt()};
}

}  // namespace pirvs
