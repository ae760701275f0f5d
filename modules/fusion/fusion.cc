#include "modules/fusion/fusion.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "core/math/so3.h"
#include "core/math/square.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

using Kind = FusionEntry::Kind;

constexpr double kRadian = kPi / 180;
constexpr TimeNs kRestart_ns = 10'000'000'000;  // without SLAM: rejected fixes are believed then
constexpr int kTrustedAgain = 3;                // accepted fixes in a row that end a doubt
// A jump that ends an alignment's window.
constexpr double kNewFrame_m = 0.5, kNewFrame_rad = 0.05;

}  // namespace

const char* name(FusionHealth health) {
  constexpr const char* kNames[] = {"none",      "aligning",  "fused",
                                    "slam only", "gnss only", "dead reckoning"};
  return health < FusionHealth::kCount ? kNames[static_cast<int>(health)] : "unknown";
}

double Fusion::Growth::add(double variance, bool begin) {
  if (!begin && variance <= top && variance > top / 2) return 0;
  const double change = begin ? 0 : std::abs(variance - top);
  top = variance;
  return change;
}

void Fusion::configure(const GnssAntenna& antenna, const FusionParams& params) {
  // Everything anew, in place, since no stack could hold it.
  this->~Fusion();
  new (this) Fusion;
  antenna_ = antenna;
  history_.configure(antenna.p_BA);
  retune(params);
}

void Fusion::retune(const FusionParams& params) {
  params_ = params;
  check_.configure(params);
  history_.retune(params);
  window_.configure(from_seconds(number(params.align_s)));
}

void Fusion::interrupt() {
  history_.clear();
  check_.forget();
  window_.clear();
  accepted_in_a_row_ = 0;
  rejected_since_ = INT64_MAX;
  slam_t_ = accepted_t_ = INT64_MIN;
  slam_runs_ = false;
  ++interruptions_;
  pose_ = FusedPose{};
  pose_.resets = history_.resets() + interruptions_;
}

FixGate Fusion::gate(const GnssFix& fix) {
  FusionEntry entry;
  entry.t = fix.t + antenna_.time_offset_ns;
  entry.kind = Kind::kFix;
  const FusionEntry* const slam = history_.last_slam();
  const Vec3* const p_W = slam == nullptr ? nullptr : &slam->slam.T_WB.p;
  FixGate verdict = check_.check(fix, entry.t, p_W, !has_origin_);
  if (verdict != FixGate::kAccepted) return verdict;
  if (!has_origin_) {
    frame_ = LocalFrame({fix.latitude_deg * kRadian, fix.longitude_deg * kRadian, fix.height_m});
    has_origin_ = true;
  }
  entry.fix = check_.measure(fix, frame_);
  if (history_.insert(entry, verdict) != Status::kOk) return FixGate::kTooLate;
  watch(entry, verdict);
  return verdict;
}

bool Fusion::add_fix(const GnssFix& fix) {
  last_gate_ = gate(fix);
  gates_.add(last_gate_);
  publish();
  return pose_.health != FusionHealth::kNone;
}

void Fusion::watch(const FusionEntry& entry, FixGate gate) {
  const bool accepted = gate != FixGate::kPosition;
  accepted_in_a_row_ = accepted ? accepted_in_a_row_ + 1 : 0;
  rejected_since_ = accepted ? INT64_MAX : std::min(rejected_since_, entry.t);
  if (accepted) accepted_t_ = entry.t;
  if (accepted) check_.judge(entry.fix.nis);
  const bool anchored = history_.newest().anchored;
  if (anchored && accepted_in_a_row_ >= kTrustedAgain) window_.clear();
  if (!anchored || !accepted) add_pair(entry);
  try_to_align();
  if (history_.newest().anchored || accepted || entry.t - rejected_since_ < kRestart_ns) return;
  history_.tell(FusionEvent::kGnssRestarted);
  history_.place_newest(entry.fix);
  rejected_since_ = INT64_MAX;
}

FusionEntry Fusion::entry_of(const Pose& pose) {
  FusionEntry out;
  out.t = pose.state.t;
  out.kind = Kind::kSlam;
  out.slam.epoch = pose.epoch;
  out.slam.T_WB = pose.state.T_WB;
  out.slam.v_WB = pose.state.v_WB;
  out.slam.w_B = pose.w_B;
  out.slam.sigma_rad = number(params_.slam_rad);
  out.slam.sigma_m = number(params_.slam_m);
  out.slam.sigma_m_s = number(params_.slam_m_s);
  const Mat9& cov = pose.cov;
  const Eigen::Matrix<double, 1, 3> up = pose.state.T_WB.R.row(2);
  const double var_yaw = (up * cov.topLeftCorner<3, 3>() * up.transpose())(0, 0);
  const bool first = slam_t_ == INT64_MIN;
  out.jumped = !first && (pose.trust.resets != slam_resets_ || !slam_runs_);
  const bool begin = first || out.jumped;
  const double var_horizontal = (cov(kPos, kPos) + cov(kPos + 1, kPos + 1)) / 2;
  out.drift_horizontal_m2 = growth_horizontal_.add(var_horizontal, begin);
  out.drift_vertical_m2 = growth_vertical_.add(cov(kPos + 2, kPos + 2), begin);
  out.drift_yaw_rad2 = growth_yaw_.add(var_yaw, begin);
  if (out.jumped) {
    // By as much as it says, which its pose then tells exactly.
    out.drift_horizontal_m2 = out.drift_vertical_m2 = square(number(pose.trust.jump_m));
    out.drift_yaw_rad2 = square(number(pose.trust.jump_rad));
  }
  const double dt = begin ? 0 : to_seconds(pose.state.t - slam_t_);
  out.drift_horizontal_m2 += square(number(params_.drift_m)) * dt;
  out.drift_vertical_m2 += square(number(params_.drift_m)) * dt;
  out.drift_yaw_rad2 += square(number(params_.drift_rad)) * dt;
  return out;
}

bool Fusion::add_pose(const Pose& pose) {
  FusionEntry entry;
  entry.t = pose.state.t;
  const bool runs = pose.health != HealthState::kLost && pose.health != HealthState::kInitializing;
  if (runs) {
    entry = entry_of(pose);
    const bool other_frame = entry.jumped && (!slam_runs_ || pose.trust.jump_m > kNewFrame_m ||
                                              pose.trust.jump_rad > kNewFrame_rad);
    if (other_frame) window_.clear();
    slam_t_ = pose.state.t;
    slam_resets_ = pose.trust.resets;
  } else {
    entry.kind = Kind::kNoSlam;
  }
  slam_runs_ = runs;
  FixGate none;
  if (history_.insert(entry, none) != Status::kOk) return false;
  publish();
  return pose_.health != FusionHealth::kNone;
}

void Fusion::add_pair(const FusionEntry& entry) {
  SlamMeasurement slam;
  if (!history_.slam_at(entry.t, slam)) return;
  const FixMeasurement& fix = entry.fix;
  AlignmentPair pair;
  pair.t = entry.t;
  pair.p_E = fix.p_E;
  pair.p_W = slam.T_WB * antenna_.p_BA;
  const double slam_m2 = square(slam.sigma_m);
  pair.var_horizontal_m2 = fix.variance.x() + slam_m2;
  pair.var_vertical_m2 = fix.variance.z() + slam_m2;
  if (fix.has_velocity) {
    pair.v_E = fix.v_E;
    pair.v_W = slam.v_WB + slam.T_WB.R * (skew(slam.w_B) * antenna_.p_BA);
    pair.var_velocity_m2_s2 = fix.velocity_variance.x() + square(slam.sigma_m_s);
  }
  window_.add(pair);
}

void Fusion::try_to_align() {
  const bool anchored = history_.newest().anchored;
  if (anchored && window_.span() < from_seconds(number(params_.doubt_s))) return;
  const FusionEntry* const slam = history_.last_slam();
  Alignment found;
  if (slam == nullptr || window_.solve(found) != Status::kOk) return;
  if (found.sigma_yaw_rad > number(params_.align_rad)) return;
  if (found.span_m < number(params_.align_span_m)) return;
  align(found, FusionEntry(*slam), history_.newest().t);
  history_.tell(anchored ? FusionEvent::kFixesBelieved : FusionEvent::kAligned);
}

// Begins anew at SLAM's last pose, and from there to now.
void Fusion::align(const Alignment& found, const FusionEntry& slam, TimeNs now) {
  check_.distrust(found.misfit);
  const double window_s = to_seconds(window_.span());
  FusionEntry start = slam;
  start.after = FusionState{};
  start.after.t = slam.t;
  place_by_anchor(start.after, found.T_EW, found.cov, slam.slam);
  const double walk_m2 = square(number(params_.drift_m)) * window_s;
  let_drift(start.after, walk_m2, walk_m2, square(number(params_.drift_rad)) * window_s);
  history_.restart(start);
  if (now > slam.t) {
    FusionEntry time;
    time.t = now;
    time.kind = Kind::kTime;
    FixGate none;
    (void)history_.insert(time, none);
  }
  window_.clear();
  accepted_in_a_row_ = 0;
  rejected_since_ = INT64_MAX;
  accepted_t_ = now;
}

// Until the heading is known: SLAM knows how little the body has moved, and which way is up, so
// that fixes can be averaged.
void Fusion::place_by_window(const FusionEntry& slam) {
  pose_.T_EB.R = slam.slam.T_WB.R;
  Vec3 p_EB;
  Mat3 cov;
  const Vec3 moved_W = to_seconds(pose_.t - slam.t) * slam.slam.v_WB;
  if (window_.locate(slam.slam.T_WB.p + moved_W, p_EB, cov) != Status::kOk) return;
  if (cov.trace() > pose_.cov.block<3, 3>(kFusePos, kFusePos).trace()) return;
  pose_.T_EB.p = p_EB;
  pose_.cov.block<3, 3>(kFusePos, kFusePos) = cov;
}

void Fusion::publish() {
  if (history_.empty() || !history_.newest().placed) return;
  const FusionState& state = history_.newest();
  pose_.t = state.t;
  pose_.T_EB = state.T_EB;
  pose_.v_EB = state.v_EB;
  pose_.cov = state.cov.topLeftCorner<9, 9>();
  pose_.has_heading = state.anchored;
  const FusionEntry* const slam = history_.last_slam();
  if (!state.anchored) {
    // The antenna's place, and the body within the lever arm of it.
    pose_.cov.block<3, 3>(kFusePos, kFusePos).diagonal().array() += antenna_.p_BA.squaredNorm();
    pose_.cov.topLeftCorner<3, 3>() = square(kPi) * Mat3::Identity();
    if (slam != nullptr) place_by_window(*slam);
  }
  pose_.place = frame_.to_global(pose_.T_EB.p);
  const bool gnss = accepted_t_ != INT64_MIN &&
                    state.t - accepted_t_ <= from_seconds(number(params_.gnss_timeout_s));
  const bool recent =
      slam != nullptr && state.t - slam->t <= from_seconds(kDeadReckoning_s);  // frames come
  const bool by_slam = recent && state.anchored;
  pose_.sources = static_cast<uint8_t>((by_slam ? kFromSlam : 0) | (gnss ? kFromGnss : 0));
  if (gnss) {
    pose_.health = by_slam  ? FusionHealth::kFused
                   : recent ? FusionHealth::kAligning
                            : FusionHealth::kGnssOnly;
  } else {
    pose_.health = by_slam ? FusionHealth::kSlamOnly : FusionHealth::kDeadReckoning;
  }
  const double variance =
      (pose_.cov(kFusePos, kFusePos) + pose_.cov(kFusePos + 1, kFusePos + 1)) / 2;
  pose_.confidence = static_cast<float>(1 / (1 + variance / square(number(params_.sigma_half_m))));
  pose_.resets = history_.resets() + interruptions_;
}

}  // namespace pirvs
