#include "modules/fusion/fusion_history.h"

#include <cmath>

#include "core/math/so3.h"
#include "core/math/square.h"
#include "modules/fusion/mm_gnss.h"
#include "modules/fusion/mm_slam.h"

namespace pirvs {
namespace {

using Kind = FusionEntry::Kind;

constexpr double kExtrapolated_s = 0.15;  // from SLAM's last pose, to pair it with a fix
constexpr double kLinear_rad = 0.03;      // a jump by more is no small error
constexpr double kFoundBack_m = 0.1, kFoundBack_rad = 0.01;  // SLAM in its old world again

}  // namespace

const char* name(FusionEvent event) {
  constexpr const char* kNames[] = {
      "fusion_aligned",    "fusion_anchored_anew",  "fusion_slam_jumped",   "fusion_heading_lost",
      "fusion_found_back", "fusion_fixes_believed", "fusion_gnss_restarted"};
  return event < FusionEvent::kCount ? kNames[static_cast<int>(event)] : "unknown";
}

void FusionHistory::tell(FusionEvent event, bool again) {
  if (again) return;
  events_.add(event);
  const bool goes_on = event == FusionEvent::kAnchoredAnew || event == FusionEvent::kSlamJumped;
  if (!goes_on) ++resets_;
}

void FusionHistory::place(FusionState& state, const FixMeasurement& fix) const {
  const TimeNs t = state.t;
  state = FusionState{};
  state.t = t;
  state.placed = true;
  state.T_EB.p = fix.p_E;
  const Vec3 speed_variance = Vec3::Constant(square(kUnknownSpeed_m_s));
  if (fix.has_velocity) state.v_EB = fix.v_E;
  state.cov.block<3, 3>(kFusePos, kFusePos) = fix.variance.asDiagonal();
  state.cov.block<3, 3>(kFuseVel, kFuseVel) =
      (fix.has_velocity ? fix.velocity_variance : speed_variance).asDiagonal();
}

FixGate FusionHistory::apply_fix(FusionState& state, FixMeasurement& fix) const {
  if (!state.placed) {
    place(state, fix);
    return FixGate::kAccepted;
  }
  const double gate = number(params_.fix_chi2);
  const Vec3 p_BA = state.anchored ? p_BA_ : Vec3::Zero();
  fix.nis = update(state, linearize_gnss_position(state, p_BA, fix.p_E, fix.variance), gate);
  if (!(fix.nis <= gate)) return FixGate::kPosition;
  if (!fix.has_velocity) return FixGate::kAccepted;
  const double nis =
      update(state, linearize_gnss_velocity(state, p_BA, fix.v_E, fix.velocity_variance), gate);
  return nis <= gate ? FixGate::kAccepted : FixGate::kVelocity;
}

// SLAM is elsewhere without a word, or is back: the anchor goes along with the body if the body's
// heading is known, else the body follows from the anchor if SLAM is in the same world.
void FusionHistory::come_back(FusionState& state, const SlamMeasurement& slam, bool again) {
  const bool heading = state.anchored && yaw_variance(state) < square(number(params_.keep_rad));
  if (heading) return anchor_anew(state, slam);
  if (state.anchored) {
    forget_heading(state, p_BA_);
    tell(FusionEvent::kHeadingLost, again);
  }
  if (!state.has_anchor || state.epoch != slam.epoch) {
    state.has_anchor = false;
    return;
  }
  Eigen::Matrix<double, 4, 4> cov = state.cov.bottomRightCorner<4, 4>();
  cov.diagonal().head<3>().array() += square(kFoundBack_m);
  cov(3, 3) += square(kFoundBack_rad);
  FusionState found = state;
  place_by_anchor(found, state.T_EW, cov, slam);
  // Where GNSS is meanwhile has a say.
  const Mat3 place_cov = state.cov.block<3, 3>(kFusePos, kFusePos);
  FusionLinear<3> m = linearize_gnss_position(found, p_BA_, state.T_EB.p, place_cov.diagonal());
  m.R = place_cov;
  const double gate = number(params_.fix_chi2);
  if (update(found, m, gate) <= gate) {
    state = found;
    tell(FusionEvent::kFoundBack, again);
  } else {
    state.has_anchor = false;
  }
}

void FusionHistory::apply_slam(FusionState& state, const FusionEntry& entry, bool again) {
  const SlamMeasurement& slam = entry.slam;
  if (!state.placed) return;
  if (!state.anchored) {
    if (state.has_anchor) come_back(state, slam, again);
    return;
  }
  if (entry.jumped) tell(FusionEvent::kAnchoredAnew, again);
  let_drift(state, entry.drift_horizontal_m2, entry.drift_vertical_m2, entry.drift_yaw_rad2);
  if (entry.drift_yaw_rad2 > square(kLinear_rad)) follow_jump(state, slam);
  const double gate = number(params_.slam_chi2);
  if (!(update(state, linearize_slam(state, slam), gate) <= gate)) {
    tell(FusionEvent::kSlamJumped, again);
    return come_back(state, slam, again);
  }
  state.w_B = slam.w_B;
  state.w_t = state.t;
  state.epoch = slam.epoch;
}

FixGate FusionHistory::apply(FusionEntry& entry, FusionState& state, bool again) {
  if (state.placed) {
    propagate(state, entry.t, number(params_.accel_m_s2), number(params_.turn_rad));
  }
  state.t = entry.t;
  const bool lost = state.anchored && yaw_variance(state) > square(number(params_.keep_rad));
  if (lost && entry.kind != Kind::kSlam) {
    forget_heading(state, p_BA_);
    tell(FusionEvent::kHeadingLost, again);
  }
  switch (entry.kind) {
    case Kind::kFix:
      return apply_fix(state, entry.fix);
    case Kind::kSlam:
      apply_slam(state, entry, again);
      break;
    case Kind::kNoSlam:
      state.w_B.setZero();
      break;
    case Kind::kTime:
      break;
  }
  return FixGate::kAccepted;
}

// What came after it is done again.
Status FusionHistory::insert(FusionEntry& entry, FixGate& verdict) {
  size_t i = size_;
  while (i > 0 && at(i - 1).t > entry.t) --i;
  if (i == 0 && size_ > 0) return Status::kStale;
  FusionState state = i == 0 ? FusionState{} : at(i - 1).after;
  if (size_ == kHistory) {
    first_ = (first_ + 1) % kHistory;
    --i;
  } else {
    ++size_;
  }
  for (size_t j = size_ - 1; j > i; --j) at(j) = at(j - 1);
  at(i) = entry;
  for (size_t j = i; j < size_; ++j) {
    const FixGate gate = apply(at(j), state, j > i);
    if (j == i) verdict = gate;
    at(j).after = state;
  }
  entry.fix.nis = at(i).fix.nis;
  return Status::kOk;
}

void FusionHistory::restart(const FusionEntry& start) {
  first_ = 0, size_ = 1;
  entries_[0] = start;
}

void FusionHistory::place_newest(const FixMeasurement& fix) { place(at(size_ - 1).after, fix); }

const FusionEntry* FusionHistory::last_slam() const {
  for (size_t i = size_; i > 0; --i) {
    if (at(i - 1).kind == Kind::kNoSlam) return nullptr;
    if (at(i - 1).kind == Kind::kSlam) return &at(i - 1);
  }
  return nullptr;
}

// Between two frames on the line and the great circle; after the last one as it moved there.
bool FusionHistory::slam_at(TimeNs t, SlamMeasurement& out) const {
  const FusionEntry* before = nullptr;
  const FusionEntry* after = nullptr;
  for (size_t i = 0; i < size_ && after == nullptr; ++i) {
    const FusionEntry& entry = at(i);
    if (entry.kind == Kind::kNoSlam) before = nullptr;
    if (entry.kind != Kind::kSlam) continue;
    (entry.t <= t ? before : after) = &entry;
  }
  if (before == nullptr) return false;
  out = before->slam;
  const double dt = to_seconds(t - before->t);
  if (after == nullptr) {
    out.T_WB.p += dt * out.v_WB;
    out.T_WB.R = out.T_WB.R * so3_exp(dt * out.w_B);
    return dt < kExtrapolated_s;
  }
  if (after->jumped) return false;
  const SlamMeasurement& next = after->slam;
  const double s = dt / to_seconds(after->t - before->t);
  out.T_WB.p += s * (next.T_WB.p - out.T_WB.p);
  out.T_WB.R = out.T_WB.R * so3_exp(s * so3_log(out.T_WB.R.transpose() * next.T_WB.R));
  out.v_WB += s * (next.v_WB - out.v_WB);
  out.w_B += s * (next.w_B - out.w_B);
  return true;
}

}  // namespace pirvs
