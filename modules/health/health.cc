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

}  // namespace

const char* name(HealthState state) {
  static constexpr const char* kNames[] = {"initializing", "tracking", "degraded", "lost"};
  static_assert(std::size(kNames) == static_cast<size_t>(HealthState::kCount));
  return kNames[static_cast<size_t>(state)];
}

void Health::started(TimeNs t) {
  state_ = HealthState::kTracking;
  last_good_ = good_since_ = t;
  good_ = true;
  blind_s_ = 0;
  trust_.confidence = kStartConfidence;
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
  trust_.confidence = judge(e);
  return state_ != before;
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
  const double sigma = e.position_sigma_m / params_.sigma_half_m;
  return static_cast<float>(vision / (1 + sigma * sigma));
}

bool Health::note_jump(double jump_m, double jump_rad, bool certain) {
  if (!certain && jump_m < params_.jump_m && jump_rad < params_.jump_rad) return false;
  ++trust_.resets;
  trust_.jump_m = static_cast<float>(jump_m);
  trust_.jump_rad = static_cast<float>(jump_rad);
  return true;
}

}  // namespace pirvs
