#include "modules/fusion/fix_check.h"

#include <algorithm>
#include <cmath>

#include "core/math/square.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr double kRadian = kPi / 180;
constexpr double kHeight_m_max = 1e5;
constexpr double kVertical2d_m = 1e3;   // what a fix without height knows of it
constexpr double kFrozen_m = 0.5;       // moved so far while the receiver gives the same numbers
constexpr double kMisclaim = 1.5;       // below that a receiver's claims are as good as held
constexpr double kClaimsFollow = 0.02;  // a fix's share in judging them
// Horizontal, by GnssFixType, of a receiver that claims nothing.
constexpr double kSigma_m[] = {5, 5, 3, 0.5, 0.02};
constexpr double kSigma_m_s = 0.3, kSigma_m_s_min = 0.01;

bool finite_and_positive(double x) { return std::isfinite(x) && x > 0; }

bool same_numbers(const GnssFix& a, const GnssFix& b) {
  return a.latitude_deg == b.latitude_deg && a.longitude_deg == b.longitude_deg &&
         a.height_m == b.height_m && a.has_velocity == b.has_velocity &&
         (!a.has_velocity || a.v_ned.head<2>() == b.v_ned.head<2>());
}

}  // namespace

const char* name(FixGate gate) {
  constexpr const char* kNames[] = {
      "fixes_accepted",  "fixes_without_fix",       "fixes_not_finite",
      "fixes_uncertain", "fixes_backwards",         "fixes_too_late",
      "fixes_frozen",    "fixes_position_rejected", "fixes_velocity_rejected"};
  return gate < FixGate::kCount ? kNames[static_cast<int>(gate)] : "unknown";
}

FixGate FixCheck::check(const GnssFix& fix, TimeNs t, const Vec3* p_W, bool is_first) {
  if (fix.type == GnssFixType::kNone) return FixGate::kNoFix;
  const bool on_earth = std::abs(fix.latitude_deg) <= 90 && std::abs(fix.longitude_deg) <= 360 &&
                        std::abs(fix.height_m) < kHeight_m_max;
  const bool speed_good = !fix.has_velocity || fix.v_ned.head<2>().allFinite();
  if (!on_earth || !speed_good) return FixGate::kNotFinite;
  if (fix.sigma_horizontal_m > number(params_.fix_m_max)) return FixGate::kUncertain;
  if (is_first && fix.type == GnssFixType::k2d) return FixGate::kUncertain;
  if (has_fix_ && t <= last_.t) return FixGate::kBackwards;
  const bool same = has_fix_ && same_numbers(fix, last_);
  has_fix_ = true;
  last_ = fix;
  last_.t = t;
  if (p_W == nullptr) return FixGate::kAccepted;
  if (!same) p_W_changed_ = *p_W;
  return same && (*p_W - p_W_changed_).norm() > kFrozen_m ? FixGate::kFrozen : FixGate::kAccepted;
}

FixMeasurement FixCheck::measure(const GnssFix& fix, const LocalFrame& frame) const {
  double horizontal = fix.sigma_horizontal_m, vertical = fix.sigma_vertical_m;
  if (!finite_and_positive(horizontal)) horizontal = kSigma_m[static_cast<int>(fix.type)];
  if (!finite_and_positive(vertical)) vertical = 2 * horizontal;
  if (fix.type == GnssFixType::k2d) vertical = kVertical2d_m;
  horizontal = misclaim_ * std::max(horizontal, number(params_.fix_m_min));
  vertical = misclaim_ * std::max(vertical, number(params_.fix_m_min));
  const Geodetic place = {fix.latitude_deg * kRadian, fix.longitude_deg * kRadian, fix.height_m};
  FixMeasurement out;
  out.p_E = frame.to_local(place);
  out.variance = Vec3(square(horizontal), square(horizontal), square(vertical));
  out.has_velocity = fix.has_velocity;
  if (!fix.has_velocity) return out;
  const bool climb = std::isfinite(fix.v_ned.z());
  const Vec3 v_enu(fix.v_ned.y(), fix.v_ned.x(), climb ? -fix.v_ned.z() : 0);
  out.v_E = frame.turn_from(place) * v_enu;
  const double claimed = fix.sigma_velocity_m_s;
  const double speed =
      finite_and_positive(claimed) ? std::max(claimed, kSigma_m_s_min) : kSigma_m_s;
  out.velocity_variance = Vec3::Constant(square(misclaim_ * speed));
  if (!climb) out.velocity_variance.z() = square(kUnknownSpeed_m_s);
  return out;
}

void FixCheck::distrust(double misfit) {
  if (misfit > kMisclaim) misclaim_ *= misfit;
}

void FixCheck::judge(double nis) {
  if (misclaim_ == 1) return;
  const double excess = std::min(nis / 3, 4.0) - 1;
  misclaim_ = std::max(1.0, misclaim_ * (1 + kClaimsFollow * excess));
}

}  // namespace pirvs
