#include "modules/fusion/fusion.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "core/math/so3.h"
#include "core/math/trig.h"
#include "modules/fusion/mm_gnss.h"
#include "modules/fusion/mm_slam.h"

namespace pirvs {
namespace {

constexpr double kRadian = kPi / 180;
constexpr double kHeight_m_max = 1e5;
constexpr double kVertical2d_m = 1e3;      // what a fix without height knows of it
constexpr double kFrozen_m = 0.5;          // moved so far while the receiver gives the same numbers
constexpr double kUnknownSpeed_m_s = 30;   // of a first fix without velocity
constexpr double kExtrapolated_s = 0.15;   // from SLAM's last pose, to pair it with a fix
constexpr TimeNs kRestart_ns = 10'000'000'000;  // without SLAM, rejected fixes are believed after that
constexpr int kTrustedAgain = 3;           // accepted fixes in a row that end a doubt
constexpr double kNewFrame_m = 0.5, kNewFrame_rad = 0.05;  // a jump that ends an alignment's window
constexpr double kFoundBack_m = 0.1, kFoundBack_rad = 0.01;  // SLAM in its old world again
constexpr double kLinear_rad = 0.03;       // a jump by more is no small error
constexpr double kMisclaim = 1.5;          // below that a receiver's claims are as good as held
constexpr double kClaimsFollow = 0.02;     // a fix's share in judging them
constexpr double kSigmaDefaults_m[][2] = {{5, 10}, {5, 10}, {3, 5}, {0.5, 1}, {0.02, 0.04}};

double square(double x) { return x * x; }
double number(float x) { return static_cast<double>(x); }

bool finite_and_positive(double x) { return std::isfinite(x) && x > 0; }

bool same_numbers(const GnssFix& a, const GnssFix& b) {
  return a.latitude_deg == b.latitude_deg && a.longitude_deg == b.longitude_deg &&
         a.height_m == b.height_m && a.has_velocity == b.has_velocity &&
         (!a.has_velocity || a.v_ned.head<2>() == b.v_ned.head<2>());
}

}  // namespace

const char* name(FusionHealth health) {
  constexpr const char* kNames[] = {"none",      "aligning",  "fused",
                                    "slam only", "gnss only", "dead reckoning"};
  return health < FusionHealth::kCount ? kNames[static_cast<int>(health)] : "unknown";
}

const char* name(FixGate gate) {
  constexpr const char* kNames[] = {
      "fixes_accepted", "fixes_without_fix", "fixes_not_finite",
      "fixes_uncertain", "fixes_backwards",  "fixes_too_late",
      "fixes_frozen",    "fixes_position_rejected", "fixes_velocity_rejected"};
  return gate < FixGate::kCount ? kNames[static_cast<int>(gate)] : "unknown";
}

const char* name(FusionEvent event) {
  constexpr const char* kNames[] = {"fusion_aligned",      "fusion_anchored_anew",
                                    "fusion_slam_jumped",  "fusion_heading_lost",
                                    "fusion_found_back",   "fusion_fixes_believed",
                                    "fusion_gnss_restarted"};
  return event < FusionEvent::kCount ? kNames[static_cast<int>(event)] : "unknown";
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
  retune(params);
}

void Fusion::retune(const FusionParams& params) {
  params_ = params;
  window_.configure(from_seconds(number(params.align_s)));
}

void Fusion::interrupt() {
  entries_ = 0;
  window_.clear();
  accepted_in_a_row_ = 0;
  rejected_since_ = INT64_MAX;
  slam_t_ = accepted_t_ = INT64_MIN;
  slam_runs_ = has_fix_ = false;
  pose_ = FusedPose{};
  pose_.resets = ++resets_;
}

void Fusion::tell(FusionEvent event, bool again) {
  if (again) return;
  events_.add(event);
  const bool goes_on = event == FusionEvent::kAnchoredAnew || event == FusionEvent::kSlamJumped;
  if (!goes_on) ++resets_;
}

// ---- one measurement ---------------------------------------------------------------------------

void Fusion::place(FusionState& state, const Fix& fix) const {
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

FixGate Fusion::apply_fix(FusionState& state, Fix& fix) const {
  if (!state.placed) {
    place(state, fix);
    return FixGate::kAccepted;
  }
  const double gate = number(params_.fix_chi2);
  const Vec3 p_BA = state.anchored ? antenna_.p_BA : Vec3::Zero();
  fix.nis = update(state, linearize_gnss_position(state, p_BA, fix.p_E, fix.variance), gate);
  if (!(fix.nis <= gate)) return FixGate::kPosition;
  if (!fix.has_velocity) return FixGate::kAccepted;
  const double nis =
      update(state, linearize_gnss_velocity(state, p_BA, fix.v_E, fix.velocity_variance), gate);
  return nis <= gate ? FixGate::kAccepted : FixGate::kVelocity;
}

// SLAM is elsewhere without a word, or is back: the anchor goes along with the body if the body's
// heading is known, else the body follows from the anchor if SLAM is in the same world.
void Fusion::come_back(FusionState& state, const Slam& slam, bool again) {
  const bool heading = state.anchored && yaw_variance(state) < square(number(params_.keep_rad));
  if (heading) return anchor_anew(state, slam.pose);
  if (state.anchored) {
    forget_heading(state, antenna_.p_BA);
    tell(FusionEvent::kHeadingLost, again);
  }
  if (!state.has_anchor || state.epoch != slam.pose.epoch) {
    state.has_anchor = false;
    return;
  }
  Eigen::Matrix<double, 4, 4> cov = state.cov.bottomRightCorner<4, 4>();
  cov.diagonal().head<3>().array() += square(kFoundBack_m);
  cov(3, 3) += square(kFoundBack_rad);
  FusionState found = state;
  place_by_anchor(found, state.T_EW, cov, slam.pose);
  // Where GNSS is meanwhile has a say.
  const Mat3 place_cov = state.cov.block<3, 3>(kFusePos, kFusePos);
  FusionLinear<3> m =
      linearize_gnss_position(found, antenna_.p_BA, state.T_EB.p, place_cov.diagonal());
  m.R = place_cov;
  const double gate = number(params_.fix_chi2);
  if (update(found, m, gate) <= gate) {
    state = found;
    tell(FusionEvent::kFoundBack, again);
  } else {
    state.has_anchor = false;
  }
}

void Fusion::apply_slam(FusionState& state, const Slam& slam, bool again) {
  if (!state.placed) return;
  if (!state.anchored) {
    if (state.has_anchor) come_back(state, slam, again);
    return;
  }
  if (slam.jumped) tell(FusionEvent::kAnchoredAnew, again);
  let_drift(state, slam.drift_horizontal_m2, slam.drift_vertical_m2, slam.drift_yaw_rad2);
  if (slam.drift_yaw_rad2 > square(kLinear_rad)) follow_jump(state, slam.pose);
  const double gate = number(params_.slam_chi2);
  if (!(update(state, linearize_slam(state, slam.pose), gate) <= gate)) {
    tell(FusionEvent::kSlamJumped, again);
    return come_back(state, slam, again);
  }
  state.w_B = slam.pose.w_B;
  state.epoch = slam.pose.epoch;
}

FixGate Fusion::apply(Entry& entry, FusionState& state, bool again) {
  if (state.placed) {
    propagate(state, entry.t, number(params_.accel_m_s2), number(params_.turn_rad));
  }
  state.t = entry.t;
  switch (entry.kind) {
    case Kind::kFix:
      return apply_fix(state, entry.fix);
    case Kind::kSlam:
      apply_slam(state, entry.slam, again);
      break;
    case Kind::kNoSlam:
      state.w_B.setZero();
      if (state.anchored && yaw_variance(state) > square(number(params_.keep_rad))) {
        forget_heading(state, antenna_.p_BA);
        tell(FusionEvent::kHeadingLost, again);
      }
      break;
    case Kind::kTime:
      break;
  }
  return FixGate::kAccepted;
}

// What came after it is done again. False: it is older than all that is kept.
bool Fusion::insert(Entry& entry, FixGate& gate) {
  size_t i = entries_;
  while (i > 0 && at(i - 1).t > entry.t) --i;
  if (i == 0 && entries_ > 0) return false;
  if (entries_ == kHistory) {
    first_ = (first_ + 1) % kHistory;
    --i;
  } else {
    ++entries_;
  }
  for (size_t j = entries_ - 1; j > i; --j) at(j) = at(j - 1);
  at(i) = entry;
  for (size_t j = i; j < entries_; ++j) {
    FusionState state = j == 0 ? FusionState{} : at(j - 1).after;
    const FixGate verdict = apply(at(j), state, j > i);
    if (j == i) gate = verdict, entry.fix.nis = at(j).fix.nis;
    at(j).after = state;
  }
  return true;
}

// ---- fixes -------------------------------------------------------------------------------------

FixGate Fusion::check(const GnssFix& fix, TimeNs t) {
  if (fix.type == GnssFixType::kNone) return FixGate::kNoFix;
  const bool on_earth = std::abs(fix.latitude_deg) <= 90 && std::abs(fix.longitude_deg) <= 360 &&
                        std::abs(fix.height_m) < kHeight_m_max;
  const bool speed_good = !fix.has_velocity || fix.v_ned.head<2>().allFinite();
  if (!on_earth || !speed_good) return FixGate::kNotFinite;
  if (fix.sigma_horizontal_m > number(params_.fix_m_max)) return FixGate::kUncertain;
  if (!has_origin_ && fix.type == GnssFixType::k2d) return FixGate::kUncertain;
  if (has_fix_ && t <= last_fix_.t) return FixGate::kBackwards;
  return is_frozen(fix, t) ? FixGate::kFrozen : FixGate::kAccepted;
}

bool Fusion::is_frozen(const GnssFix& fix, TimeNs t) {
  const bool same = has_fix_ && same_numbers(fix, last_fix_);
  has_fix_ = true;
  last_fix_ = fix;
  last_fix_.t = t;
  const Entry* const slam = last_slam();
  if (slam == nullptr) return false;
  const Vec3& p_W = slam->slam.pose.T_WB.p;
  if (!same) p_W_changed_ = p_W;
  return same && (p_W - p_W_changed_).norm() > kFrozen_m;
}

Fusion::Fix Fusion::measured(const GnssFix& fix) const {
  const auto& defaults = kSigmaDefaults_m[static_cast<int>(fix.type)];
  double horizontal = fix.sigma_horizontal_m, vertical = fix.sigma_vertical_m;
  if (!finite_and_positive(horizontal)) horizontal = defaults[0];
  if (!finite_and_positive(vertical)) vertical = 2 * horizontal;
  if (fix.type == GnssFixType::k2d) vertical = kVertical2d_m;
  horizontal = misclaim_ * std::max(horizontal, number(params_.fix_m_min));
  vertical = misclaim_ * std::max(vertical, number(params_.fix_m_min));
  const Geodetic place = {fix.latitude_deg * kRadian, fix.longitude_deg * kRadian, fix.height_m};
  Fix out;
  out.p_E = frame_.to_local(place);
  out.variance = Vec3(square(horizontal), square(horizontal), square(vertical));
  out.has_velocity = fix.has_velocity;
  if (!fix.has_velocity) return out;
  const bool climb = std::isfinite(fix.v_ned.z());
  const Vec3 v_enu(fix.v_ned.y(), fix.v_ned.x(), climb ? -fix.v_ned.z() : 0);
  out.v_E = frame_.turn_from(place) * v_enu;
  constexpr double kDefault_m_s = 0.3, kLeast_m_s = 0.01;
  const double claimed = fix.sigma_velocity_m_s;
  const double speed = finite_and_positive(claimed) ? std::max(claimed, kLeast_m_s) : kDefault_m_s;
  out.velocity_variance = Vec3::Constant(square(misclaim_ * speed));
  if (!climb) out.velocity_variance.z() = square(kUnknownSpeed_m_s);
  return out;
}

bool Fusion::add_fix(const GnssFix& fix) {
  const TimeNs t = fix.t + antenna_.time_offset_ns;
  last_gate_ = check(fix, t);
  if (last_gate_ == FixGate::kAccepted) {
    if (!has_origin_) {
      frame_ = LocalFrame(
          {fix.latitude_deg * kRadian, fix.longitude_deg * kRadian, fix.height_m});
      has_origin_ = true;
    }
    Entry entry;
    entry.t = t;
    entry.fix = measured(fix);
    if (!insert(entry, last_gate_)) last_gate_ = FixGate::kTooLate;
    if (last_gate_ != FixGate::kTooLate) watch(entry, last_gate_);
  }
  gates_.add(last_gate_);
  publish();
  return has_origin_;
}

void Fusion::watch(const Entry& entry, FixGate gate) {
  const bool accepted = gate != FixGate::kPosition;
  accepted_in_a_row_ = accepted ? accepted_in_a_row_ + 1 : 0;
  rejected_since_ = accepted ? INT64_MAX : std::min(rejected_since_, entry.t);
  if (accepted) accepted_t_ = entry.t;
  if (accepted && misclaim_ > 1) {
    const double excess = std::min(entry.fix.nis / 3, 4.0) - 1;
    misclaim_ = std::max(1.0, misclaim_ * (1 + kClaimsFollow * excess));
  }
  const bool anchored = newest()->anchored;
  if (anchored && accepted_in_a_row_ >= kTrustedAgain) window_.clear();
  if (!anchored || !accepted) add_pair(entry);
  try_to_align();
  if (newest()->anchored || accepted || entry.t - rejected_since_ < kRestart_ns) return;
  tell(FusionEvent::kGnssRestarted, false);
  Entry& last = at(entries_ - 1);
  place(last.after, entry.fix);
  rejected_since_ = INT64_MAX;
}

// ---- SLAM --------------------------------------------------------------------------------------

Fusion::Slam Fusion::slam_of(const Pose& pose) {
  Slam out;
  out.pose.epoch = pose.epoch;
  out.pose.T_WB = pose.state.T_WB;
  out.pose.v_WB = pose.state.v_WB;
  out.pose.w_B = pose.w_B;
  out.pose.sigma_rad = number(params_.slam_rad);
  out.pose.sigma_m = number(params_.slam_m);
  out.pose.sigma_m_s = number(params_.slam_m_s);
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
  Entry entry;
  entry.t = pose.state.t;
  const bool runs =
      pose.health != HealthState::kLost && pose.health != HealthState::kInitializing;
  if (runs) {
    entry.kind = Kind::kSlam;
    entry.slam = slam_of(pose);
    const bool other_frame =
        entry.slam.jumped && (!slam_runs_ || pose.trust.jump_m > kNewFrame_m ||
                              pose.trust.jump_rad > kNewFrame_rad);
    if (other_frame) window_.clear();
    slam_t_ = pose.state.t;
    slam_resets_ = pose.trust.resets;
  } else {
    entry.kind = Kind::kNoSlam;
  }
  slam_runs_ = runs;
  FixGate none;
  if (!insert(entry, none)) return false;
  publish();
  return pose_.health != FusionHealth::kNone;
}

const Fusion::Entry* Fusion::last_slam() const {
  for (size_t i = entries_; i > 0; --i) {
    if (at(i - 1).kind == Kind::kNoSlam) return nullptr;
    if (at(i - 1).kind == Kind::kSlam) return &at(i - 1);
  }
  return nullptr;
}

// Between two frames on the line and the great circle; after the last one as it moved there.
bool Fusion::slam_at(TimeNs t, SlamMeasurement& out) const {
  const Entry* before = nullptr;
  const Entry* after = nullptr;
  for (size_t i = 0; i < entries_ && after == nullptr; ++i) {
    const Entry& entry = at(i);
    if (entry.kind == Kind::kNoSlam) before = nullptr;
    if (entry.kind != Kind::kSlam) continue;
    (entry.t <= t ? before : after) = &entry;
  }
  if (before == nullptr) return false;
  out = before->slam.pose;
  const double dt = to_seconds(t - before->t);
  if (after == nullptr) {
    out.T_WB.p += dt * out.v_WB;
    out.T_WB.R = out.T_WB.R * so3_exp(dt * out.w_B);
    return dt < kExtrapolated_s;
  }
  if (after->slam.jumped) return false;
  const SlamMeasurement& next = after->slam.pose;
  const double s = dt / to_seconds(after->t - before->t);
  out.T_WB.p += s * (next.T_WB.p - out.T_WB.p);
  out.T_WB.R = out.T_WB.R * so3_exp(s * so3_log(out.T_WB.R.transpose() * next.T_WB.R));
  out.v_WB += s * (next.v_WB - out.v_WB);
  out.w_B += s * (next.w_B - out.w_B);
  return true;
}

// ---- alignment ---------------------------------------------------------------------------------

void Fusion::add_pair(const Entry& entry) {
  SlamMeasurement slam;
  if (!slam_at(entry.t, slam)) return;
  const Fix& fix = entry.fix;
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
  const bool anchored = newest()->anchored;
  if (anchored && window_.span() < from_seconds(number(params_.doubt_s))) return;
  const Entry* const slam = last_slam();
  Alignment found;
  if (slam == nullptr || window_.solve(found) != Status::kOk) return;
  if (found.sigma_yaw_rad > number(params_.align_rad)) return;
  if (found.span_m < number(params_.align_span_m)) return;
  align(found, Entry(*slam), newest()->t);
  tell(anchored ? FusionEvent::kFixesBelieved : FusionEvent::kAligned, false);
}

// Begins anew at SLAM's last pose, and from there to now.
void Fusion::align(const Alignment& found, const Entry& slam, TimeNs now) {
  if (found.misfit > kMisclaim) misclaim_ *= found.misfit;
  const double window_s = to_seconds(window_.span());
  Entry start = slam;
  start.after = FusionState{};
  start.after.t = slam.t;
  place_by_anchor(start.after, found.T_EW, found.cov, slam.slam.pose);
  const double walk_m2 = square(number(params_.drift_m)) * window_s;
  let_drift(start.after, walk_m2, walk_m2, square(number(params_.drift_rad)) * window_s);
  first_ = 0, entries_ = 1;
  history_[0] = start;
  if (now > slam.t) {
    Entry time;
    time.t = now;
    time.kind = Kind::kTime;
    FixGate none;
    (void)insert(time, none);
  }
  window_.clear();
  accepted_in_a_row_ = 0;
  rejected_since_ = INT64_MAX;
  accepted_t_ = now;
}

// ---- out ---------------------------------------------------------------------------------------

void Fusion::publish() {
  const FusionState* const state = newest();
  if (state == nullptr || !state->placed) return;
  pose_.t = state->t;
  pose_.T_EB = state->T_EB;
  pose_.v_EB = state->v_EB;
  pose_.cov = state->cov.topLeftCorner<9, 9>();
  pose_.has_heading = state->anchored;
  const Entry* const slam = last_slam();
  if (!state->anchored) {
    // The antenna's place, and the body within the lever arm of it.
    pose_.cov.block<3, 3>(kFusePos, kFusePos).diagonal().array() += antenna_.p_BA.squaredNorm();
    pose_.cov.topLeftCorner<3, 3>() = square(kPi) * Mat3::Identity();
    if (slam != nullptr) pose_.T_EB.R = slam->slam.pose.T_WB.R;
  }
  pose_.place = frame_.to_global(pose_.T_EB.p);
  const bool gnss = accepted_t_ != INT64_MIN &&
                    state->t - accepted_t_ <= from_seconds(number(params_.gnss_timeout_s));
  const bool by_slam = slam != nullptr && state->anchored;
  pose_.sources = static_cast<uint8_t>((by_slam ? kFromSlam : 0) | (gnss ? kFromGnss : 0));
  if (gnss) {
    pose_.health = by_slam             ? FusionHealth::kFused
                   : slam != nullptr   ? FusionHealth::kAligning
                                       : FusionHealth::kGnssOnly;
  } else {
    pose_.health = by_slam ? FusionHealth::kSlamOnly : FusionHealth::kDeadReckoning;
  }
  const double variance =
      (pose_.cov(kFusePos, kFusePos) + pose_.cov(kFusePos + 1, kFusePos + 1)) / 2;
  pose_.confidence =
      static_cast<float>(1 / (1 + variance / square(number(params_.sigma_half_m))));
  pose_.resets = resets_;
}

}  // namespace pirvs
