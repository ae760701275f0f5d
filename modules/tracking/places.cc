#include "modules/tracking/places.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "core/math/so3.h"

namespace pirvs {
namespace {

// A recognised place is not better known than this; a loop that is off by less is closed already.
constexpr double kLocated_rad = 0.002, kLocated_m = 0.01;
constexpr double kLoopChi2_max = 18.5;  // 4 dof, 99.9 %

}  // namespace

Mat6 error_of_sigmas(double sigma_rad, double sigma_m) {
  Vec6 sigma;
  sigma << Vec3::Constant(sigma_rad), Vec3::Constant(sigma_m);
  return sigma.cwiseAbs2().asDiagonal();
}

void Places::configure(const Camera* cameras, int count, const ImuNoise& noise,
                       const FilterParams& filter, const MatchingParams& matching,
                       const TrackerParams& params) {
  filter_params_ = filter;
  params_ = params;
  locator_.configure(cameras, noise, filter);
  recogniser_.configure(cameras, count, matching);
}

bool Places::solve(PlaceRule rule, const Mat3& R_WB, const Associator& seen, uint32_t before) {
  const Tracks* const tracks[kCamerasMax] = {&seen.tracks(0), &seen.tracks(1)};
  return recogniser_.solve(seen.map(), rule, R_WB, tracks, found_, before);
}

PlaceAnswer Places::recognise(TimeNs t, PlaceRule rule, const Mat3& R_WB, const Associator& seen) {
  if (to_seconds(t - last_recognise_t_) < params_.recognise_every_s) return PlaceAnswer::kNotAsked;
  last_recognise_t_ = t;
  if (!solve(rule, R_WB, seen)) return PlaceAnswer::kUnknown;
  refine(seen);
  return PlaceAnswer::kFound;
}

// Three points said where it is, to centimetres; all of them know it better. The tilt stays.
void Places::refine(const Associator& seen) {
  if (2 * locate(seen) < static_cast<int>(found_.matches.size())) return;
  const SE3& T_WB = locator_.state().T_WB;
  const double turn_rad = so3_log(T_WB.R * found_.T_WB.R.transpose()).z();
  found_.T_WB = {so3_exp(Vec3(0, 0, turn_rad)) * found_.T_WB.R, T_WB.p};
}

bool Places::found_is_planar(const Associator& seen) const {
  constexpr double kThin = 0.03;  // of the distance; a plane's points have 0.013, a hall's 0.05 on
  const double count = static_cast<double>(found_.matches.size());
  Vec3 mean = Vec3::Zero();
  for (const Recognition::Match& match : found_.matches) {
    mean += seen.map().find(match.landmark)->p_W / count;
  }
  Mat3 scatter = 1e-9 * Mat3::Identity();
  for (const Recognition::Match& match : found_.matches) {
    const Vec3 d = seen.map().find(match.landmark)->p_W - mean;
    scatter += d * d.transpose() / count;
  }
  // The harmonic sum of the variances along the axes is that of the thinnest, or a little less.
  const double thickness_m = 1 / std::sqrt(scatter.inverse().trace());
  return !(thickness_m > kThin * (mean - found_.T_WB.p).norm());
}

// The pose from what was recognised, left in locator_.
int Places::locate(const Associator& seen) {
  correspondences_.clear();
  for (const Recognition::Match& match : found_.matches) {
    const Track& track = seen.tracks(match.camera)[match.track];
    const MapPoint* point = seen.map().find(match.landmark);
    if (point == nullptr) continue;
    (void)correspondences_.push_back({point->p_W, point->cov, Vec2(track.x, track.y),
                                      filter_params_.sigma_px, match.camera, Gate::kAccepted});
  }
  return locator_.locate(found_.T_WB, {kRecognised_rad, kRecognised_m, 0.2}, correspondences_);
}

bool Places::held(const Associator& seen, uint32_t& closes_to) const {
  FixedVector<uint32_t, kCamerasMax * kTracksMax> last_seen;
  for (const Recognition::Match& match : found_.matches) {
    (void)last_seen.push_back(seen.map().find(match.landmark)->last_keyframe);
  }
  std::sort(last_seen.begin(), last_seen.end());
  closes_to = last_seen.back();
  const int as_old = seen.tracked_made_by(last_seen[last_seen.size() / 2]);
  return static_cast<float>(as_old) > params_.loop_held_max * static_cast<float>(last_seen.size());
}

LoopDecision Places::test_loop(TimeNs t, const SE3& T_WB, const MapError& error,
                               uint32_t drifted_after, const Associator& seen) {
  LoopDecision out;
  if (to_seconds(t - last_loop_t_) < params_.loop_every_s) return out;
  last_loop_t_ = t;
  // After a drift the pose is in doubt, and half as many serve; here none of them may be wallpaper.
  const bool drifted = drifted_after != 0;
  const int wanted = static_cast<int>(params_.loop_matches_min) / (drifted ? 2 : 1);
  const PlaceRule rule = drifted ? PlaceRule::kBefore : PlaceRule::kOld;
  if (!solve(rule, T_WB.R, seen, drifted_after) || locate(seen) < wanted) return out;
  if (drifted && found_is_planar(seen)) return out;
  const SE3& T_found = locator_.state().T_WB;
  Vec6 xi;
  xi << so3_log(T_found.R * T_WB.R.transpose()), T_found.p - T_WB.p;
  out.off = gauge_of(xi);
  const Mat6 located = error_of_pose(T_found.R, locator_.cov().topLeftCorner<6, 6>()) +
                       error_of_sigmas(kLocated_rad, kLocated_m);
  out.off_cov = gauge_of(located);
  if (out.off.dot(out.off_cov.inverse() * out.off) < kLoopChi2_max) return out;
  const Mat6 here = error_about(T_WB.p, error.at, error.cov);
  const Mat4 S = params_.cov_scale * gauge_of(here) + out.off_cov;
  if (out.off.dot(S.inverse() * out.off) > kLoopChi2_max) {
    out.verdict = LoopDecision::Verdict::kImplausible;
    return out;
  }
  out.verdict =
      held(seen, out.closes_to) ? LoopDecision::Verdict::kHeld : LoopDecision::Verdict::kCloses;
  xi.head<2>().setZero();
  out.T = motion_of(xi, T_WB.p);
  return out;
}

}  // namespace pirvs
