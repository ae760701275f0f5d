#include "modules/health/health.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace pirvs {

namespace {

constexpr float kStartConfidence = 0.5f;
constexpr double kRestConfidence = 0.9;   // held by zero velocity, whatever is seen
constexpr double kBlindConfidence = 0.5;  // at once; from there it falls with time
constexpr double kSpreadFull = 1.5;       // two thirds of the cells are as good as all
constexpr double kDoubted = 0.5;          // at most, with any reason
constexpr double kRejected_s = 0.5;       // over which the share of the rejected is a mean
constexpr double kRejectedLong_s = 5, kStillMany = 0.6;  // for longer, less is too many
constexpr double kJumps_s = 10;                          // after which a jump counts a third
constexpr double kHopelessJumps = 6;                     // times what is doubted
constexpr double kHopeless_s = 1;                        // of which no way leads back
constexpr double kDenied_s = 10;                         // for which a start after that is doubted
constexpr double kHopelessBias = 3;                      // times what is doubted

}  // namespace

const char* name(HealthState state) {
  static constexpr const char* kNames[] = {"initializing", "tracking", "degraded", "lost"};
  static_assert(std::size(kNames) == static_cast<size_t>(HealthState::kCount));
  return kNames[static_cast<size_t>(state)];
}

const char* name(Reason reason) {
  static constexpr const char* kNames[] = {"blind",     "rejected", "jumps",  "accel_bias",
                                           "gyro_bias", "speed",    "stamps", "denied",
                                           "platform",  "cameras",  "turn"};
  static_assert(std::size(kNames) == static_cast<size_t>(Reason::kCount));
  return kNames[static_cast<size_t>(reason)];
}

void Health::started(TimeNs t) {
  state_ = HealthState::kTracking;
  last_good_ = good_since_ = t;
  good_ = true;
  blind_s_ = rejected_share_ = rejected_long_ = jumps_ = hopeless_s_ = 0;
  last_t_ = t;
  trust_.confidence = kStartConfidence;
  trust_.reasons = 0;
  denied_until_ = denied_ ? t + from_seconds(kDenied_s) : 0;
  denied_ = false;
}

bool Health::update(const FrameEvidence& e) {
  const HealthState before = state_;
  if (e.accepted >= static_cast<int>(params_.matches_min) || e.at_rest) last_good_ = e.t;
  blind_s_ = to_seconds(e.t - last_good_);
  const bool good = e.accepted >= static_cast<int>(params_.recover_matches) || e.at_rest;
  if (good && !good_) good_since_ = e.t;
  good_ = good;
  if (state_ == HealthState::kTracking && blind_s_ > 0) {
    state_ = HealthState::kDegraded;
  } else if (state_ == HealthState::kDegraded) {
    if (good && to_seconds(e.t - good_since_) >= params_.recover_s) {
      state_ = HealthState::kTracking;
    } else if (blind_s_ > params_.lost_s && e.position_sigma_m > params_.lost_sigma_m) {
      state_ = HealthState::kLost;
    }
  }
  const double dt_s = std::clamp(to_seconds(e.t - last_t_), 0.0, 1.0);
  last_t_ = e.t;
  trust_.reasons = find_reasons(e, dt_s);
  hopeless_s_ = hopeless(e) ? hopeless_s_ + dt_s : 0;
  denied_ = hopeless_s_ > kHopeless_s;
  if (denied_) state_ = HealthState::kLost;
  trust_.confidence = judge(e);
  return state_ != before;
}

uint16_t Health::find_reasons(const FrameEvidence& e, double dt_s) {
  const int seen = e.accepted + e.rejected;
  const double share = seen > 0 ? static_cast<double>(e.rejected) / seen : 0.0;
  rejected_share_ += std::min(1.0, dt_s / kRejected_s) * (share - rejected_share_);
  rejected_long_ += std::min(1.0, dt_s / kRejectedLong_s) * (share - rejected_long_);
  jumps_ -= std::min(1.0, dt_s / kJumps_s) * jumps_;
  uint16_t out = 0;
  const auto doubt = [&out](Reason reason, bool holds) { out |= holds ? bit(reason) : 0; };
  doubt(Reason::kBlind, !e.at_rest && e.accepted < static_cast<int>(params_.matches_min));
  const double many = params_.rejected_share_max, still_many = kStillMany * many;
  const bool was = (trust_.reasons & bit(Reason::kRejected)) != 0;
  doubt(Reason::kRejected,
        rejected_share_ > (was ? still_many : many) || (rejected_long_ > still_many && !e.at_rest));
  doubt(Reason::kJumps, jumps_ > params_.jumps_max);
  doubt(Reason::kAccelBias, e.accel_bias_m_s2 > params_.accel_bias_max_m_s2);
  doubt(Reason::kGyroBias, e.gyro_bias_rad_s > params_.gyro_bias_max_rad_s);
  doubt(Reason::kSpeed, e.speed_m_s > params_.speed_max_m_s);
  doubt(Reason::kStamps, in_doubt_ && !e.at_rest);
  doubt(Reason::kDenied, e.t < denied_until_);
  doubt(Reason::kPlatform, e.moved_along);
  doubt(Reason::kCameras, e.cameras_disagree);
  doubt(Reason::kTurn, e.turns_against);
  return out;
}

// What only a new start can mend. NaN is hopeless, too.
bool Health::hopeless(const FrameEvidence& e) {
  const bool sound = e.speed_m_s <= params_.speed_max_m_s &&
                     e.accel_bias_m_s2 <= kHopelessBias * params_.accel_bias_max_m_s2 &&
                     e.gyro_bias_rad_s <= kHopelessBias * params_.gyro_bias_max_rad_s;
  const double rejected_max = 0.5 * (1 + params_.rejected_share_max);
  return !sound || jumps_ > kHopelessJumps * params_.jumps_max ||
         (rejected_share_ > rejected_max && !e.at_rest);
}

// Vision's part, times what the filter says of the place.
float Health::judge(const FrameEvidence& e) const {
  if (state_ == HealthState::kLost || state_ == HealthState::kInitializing) return 0;
  double vision = kRestConfidence;
  if (e.accepted >= static_cast<int>(params_.matches_min)) {
    const double spread = std::min(1.0, kSpreadFull * e.cells / kCells);
    vision = std::min(1.0, static_cast<double>(e.accepted) / params_.full_matches);
    vision *= 0.5 + 0.5 * spread;
    if (e.at_rest) vision = std::max(vision, kRestConfidence);
  } else if (!e.at_rest) {
    vision = kBlindConfidence / (1 + blind_s_ / params_.blind_half_s);
  }
  if (in_doubt_ && !e.at_rest) vision = std::min(vision, static_cast<double>(kDoubtConfidence));
  const uint16_t own = bit(Reason::kBlind) | bit(Reason::kStamps);  // said above
  const bool recovers = state_ == HealthState::kDegraded && !e.at_rest;
  if ((trust_.reasons & ~own) != 0 || recovers) vision = std::min(vision, kDoubted);
  const double sigma = e.position_sigma_m / params_.sigma_half_m;
  return static_cast<float>(vision / (1 + sigma * sigma));
}

bool Health::note_jump(double jump_m, double jump_rad, bool certain) {
  if (!certain && jump_m < params_.jump_m && jump_rad < params_.jump_rad) return false;
  ++trust_.resets;
  if (!certain) jumps_ += 1;
  trust_.jump_m = static_cast<float>(jump_m);
  trust_.jump_rad = static_cast<float>(jump_rad);
  return true;
}

}  // namespace pirvs
