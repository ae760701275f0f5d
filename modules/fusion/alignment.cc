#include "modules/fusion/alignment.h"

#include <algorithm>
#include <cmath>

#include "core/math/square.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

// A stretch whose residuals are so many times their sigmas does not belong to the others.
constexpr double kOutlier = 3.0;

}  // namespace

void AlignmentWindow::Sums::add(const Sums& o) {
  pairs += o.pairs, velocities += o.velocities;
  w += o.w, a += o.a, b += o.b;
  dot += o.dot, cross += o.cross, aa += o.aa, bb += o.bb;
  v_dot += o.v_dot, v_cross += o.v_cross, v_aa += o.v_aa, v_bb += o.v_bb;
  up_w += o.up_w, up_d += o.up_d, up_dd += o.up_dd;
}

void AlignmentWindow::add(const AlignmentPair& pair) {
  Sums one;
  one.pairs = 1;
  one.w = 1 / pair.var_horizontal_m2;
  const Vec2 a = pair.p_E.head<2>(), b = pair.p_W.head<2>();
  one.a = one.w * a, one.b = one.w * b;
  one.dot = one.w * a.dot(b), one.cross = one.w * (b.x() * a.y() - b.y() * a.x());
  one.aa = one.w * a.squaredNorm(), one.bb = one.w * b.squaredNorm();
  if (pair.var_velocity_m2_s2 > 0) {
    const double w = 1 / pair.var_velocity_m2_s2;
    const Vec2 va = pair.v_E.head<2>(), vb = pair.v_W.head<2>();
    one.velocities = 1;
    one.v_dot = w * va.dot(vb), one.v_cross = w * (vb.x() * va.y() - vb.y() * va.x());
    one.v_aa = w * va.squaredNorm(), one.v_bb = w * vb.squaredNorm();
  }
  one.up_w = 1 / pair.var_vertical_m2;
  const double up = pair.p_E.z() - pair.p_W.z();
  one.up_d = one.up_w * up, one.up_dd = one.up_w * up * up;

  size_t gone = 0;
  while (gone < stretches_.size() && pair.t - stretches_[gone].begin >= length_) ++gone;
  for (size_t i = gone; i < stretches_.size(); ++i) stretches_[i - gone] = stretches_[i];
  stretches_.resize(stretches_.size() - gone);
  if (stretches_.empty() || pair.t - stretches_.back().begin >= length_ / (kStretches - 1)) {
    Stretch* const fresh = stretches_.append();
    *fresh = Stretch{};
    fresh->begin = pair.t;
    fresh->p_W_min = fresh->p_W_max = pair.p_W;
  }
  Stretch& stretch = stretches_.back();
  stretch.end = pair.t;
  stretch.p_W_min = stretch.p_W_min.cwiseMin(pair.p_W);
  stretch.p_W_max = stretch.p_W_max.cwiseMax(pair.p_W);
  stretch.sums.add(one);
}

AlignmentWindow::Fit AlignmentWindow::fit(const Sums& sums) {
  Fit out;
  const Vec2 a = sums.a / sums.w, b = sums.b / sums.w;
  const double dot = sums.dot - sums.w * a.dot(b) + sums.v_dot;
  const double cross = sums.cross - sums.w * (b.x() * a.y() - b.y() * a.x()) + sums.v_cross;
  const double length = std::sqrt(dot * dot + cross * cross);
  if (length > 0) out.s = cross / length, out.c = dot / length;
  out.p = a - Vec2(out.c * b.x() - out.s * b.y(), out.s * b.x() + out.c * b.y());
  out.up = sums.up_d / sums.up_w;
  out.information = sums.bb - sums.w * b.squaredNorm() + sums.v_bb;
  return out;
}

// Sum of squared residuals over their variances.
double AlignmentWindow::cost(const Sums& sums, const Fit& f) {
  const Vec2 turned_b(f.c * sums.b.x() - f.s * sums.b.y(), f.s * sums.b.x() + f.c * sums.b.y());
  const double place = sums.aa + sums.bb + sums.w * f.p.squaredNorm() -
                       2 * (f.c * sums.dot + f.s * sums.cross) - 2 * f.p.dot(sums.a) +
                       2 * f.p.dot(turned_b);
  const double velocity = sums.v_aa + sums.v_bb - 2 * (f.c * sums.v_dot + f.s * sums.v_cross);
  const double vertical = sums.up_dd - 2 * f.up * sums.up_d + square(f.up) * sums.up_w;
  return std::max(0.0, place + velocity + vertical);
}

void AlignmentWindow::choose(Chosen& out) const {
  std::fill_n(out.used, kStretches, true);
  for (const Stretch& stretch : stretches_) out.all += stretch.sums.pairs;
  while (out.all > 0) {
    out.sums = Sums{};
    for (size_t i = 0; i < stretches_.size(); ++i) {
      if (out.used[i]) out.sums.add(stretches_[i].sums);
    }
    out.fit = fit(out.sums);
    out.cost = cost(out.sums, out.fit);
    size_t worst = 0;
    double worst_mean = square(kOutlier);
    for (size_t i = 0; i < stretches_.size(); ++i) {
      const Sums& s = stretches_[i].sums;
      const double mean = cost(s, out.fit) / squares(s);
      if (out.used[i] && mean > worst_mean) worst = i, worst_mean = mean;
    }
    const bool any = worst_mean > square(kOutlier);
    if (!any || 2 * (out.sums.pairs - stretches_[worst].sums.pairs) <= out.all) break;
    out.used[worst] = false;
  }
}

Status AlignmentWindow::locate(const Vec3& p_W, Vec3& p_E, Mat3& cov) const {
  Chosen chosen;
  choose(chosen);
  if (chosen.all == 0) return Status::kEmpty;
  const Sums& sums = chosen.sums;
  const Fit& f = chosen.fit;
  // A heading of variance v turns an arm to exp(-v / 2) of it in the mean.
  const double kept = f.information > 0 ? exponential(-0.5 / f.information) : 0;
  const Vec2 a = sums.a / sums.w, arm = p_W.head<2>() - sums.b / sums.w;
  p_E << a + kept * Vec2(f.c * arm.x() - f.s * arm.y(), f.s * arm.x() + f.c * arm.y()),
      p_W.z() + f.up;
  const double scale = std::max(1.0, chosen.cost / squares(sums));
  const double horizontal = scale / sums.w + (1 - kept * kept) * arm.squaredNorm();
  cov = Vec3(horizontal, horizontal, scale / sums.up_w).asDiagonal();
  return Status::kOk;
}

Status AlignmentWindow::solve(Alignment& out) const {
  Chosen chosen;
  choose(chosen);
  const Sums& sums = chosen.sums;
  const Fit& found = chosen.fit;
  if (sums.pairs < kPairsMin || !(found.information > 0)) return Status::kEmpty;

  out = Alignment{};
  out.pairs = sums.pairs;
  out.left_out = chosen.all - sums.pairs;
  const double scale = std::max(1.0, chosen.cost / (squares(sums) - 4));
  out.misfit = std::sqrt(chosen.cost / (squares(sums) - 4));
  out.T_EW.R << found.c, -found.s, 0, found.s, found.c, 0, 0, 0, 1;
  out.T_EW.p << found.p, found.up;
  const double var_yaw = scale / found.information;
  out.sigma_yaw_rad = std::sqrt(var_yaw);
  // The place is known at the mean of the pairs, apart from the heading.
  const Vec2 b = sums.b / sums.w;
  const Vec2 arm(found.c * b.x() - found.s * b.y(), found.s * b.x() + found.c * b.y());
  const Vec3 u(arm.y(), -arm.x(), 0);
  out.cov.topLeftCorner<3, 3>() = var_yaw * u * u.transpose();
  out.cov.topLeftCorner<3, 3>().diagonal() +=
      Vec3(scale / sums.w, scale / sums.w, scale / sums.up_w);
  out.cov.block<3, 1>(0, 3) = var_yaw * u;
  out.cov.block<1, 3>(3, 0) = var_yaw * u.transpose();
  out.cov(3, 3) = var_yaw;
  Vec3 low, high;
  bool first = true;
  for (size_t i = 0; i < stretches_.size(); ++i) {
    if (!chosen.used[i]) continue;
    low = first ? stretches_[i].p_W_min : Vec3(low.cwiseMin(stretches_[i].p_W_min));
    high = first ? stretches_[i].p_W_max : Vec3(high.cwiseMax(stretches_[i].p_W_max));
    first = false;
  }
  out.span_m = (high - low).head<2>().norm();
  return Status::kOk;
}

}  // namespace pirvs
