#include "modules/matching/recognise.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/kernels/hamming/hamming.h"
#include "core/math/random.h"

namespace pirvs {
namespace {

constexpr int kSample = 3;
constexpr int kTries = 300;
constexpr double kFit_rad2 = 0.01 * 0.01;  // 4.6 px of EuRoC's lens
constexpr double kDistance_m_min = 0.1;
constexpr double kNorm_tolerance = 0.2;  // of cos^2 + sin^2, which the linear fit leaves free

Vec3 turned_back(const Vec3& p_W, double c, double s) {
  return {c * p_W.x() + s * p_W.y(), -s * p_W.x() + c * p_W.y(), p_W.z()};
}

}  // namespace

void Recogniser::configure(const Camera* cameras, int count, const MatchingParams& params) {
  for (int c = 0; c < count; ++c) camera_[c] = cameras[c];
  cameras_ = count;
  params_ = params;
}

void Recogniser::find_candidates(const MapView& view, PlaceRule rule, uint32_t before) {
  candidates_.clear();
  if (rule == PlaceRule::kOld) {
    const uint32_t ago = static_cast<uint32_t>(params_.loop_keyframes_min);
    for (const uint16_t p : view.local()) {
      if (view.point(p).last_keyframe + ago < view.keyframe()) (void)candidates_.push_back(p);
    }
    return;
  }
  for (size_t i = 0; i < view.points(); ++i) {
    const uint16_t p = static_cast<uint16_t>(i);
    const bool same = view.point(p).epoch == view.epoch();
    if (rule == PlaceRule::kBefore && view.point(p).last_keyframe > before) continue;
    if (same != (rule == PlaceRule::kOther)) (void)candidates_.push_back(p);
  }
}

void Recogniser::find_pairs(const MapView& view, const Mat3& R_WB, const Tracks* const* tracks) {
  pairs_.clear();
  for (int c = 0; c < cameras_; ++c) {
    const Mat3 R_LC = R_WB * camera_[c].T_BC.R;
    for (size_t i = 0; i < tracks[c]->size(); ++i) {
      const Track& track = (*tracks[c])[i];
      Vec3 f_C;
      if (!track.described || !camera_[c].unproject(Vec2(track.x, track.y), f_C)) continue;
      int best = -1, distance = kHammingNone, second = kHammingNone;
      for (const uint16_t p : candidates_) {
        const int d = hamming(track.descriptor, view.point(p).descriptor);
        if (d < distance) {
          second = distance;
          distance = d;
          best = p;
        } else if (d < second) {
          second = d;
        }
      }
      if (!is_match(params_, distance, second)) continue;
      (void)pairs_.push_back({static_cast<uint8_t>(c), static_cast<uint16_t>(i),
                              static_cast<uint16_t>(best), R_LC * f_C.normalized(),
                              R_WB * camera_[c].T_BC.p, view.point(static_cast<uint16_t>(best)).p_W,
                              false});
    }
  }
}

// (I - f f') (Rz' p_W - s - c) = 0, linear in cos, sin and s; then s alone, with the turn made one.
bool Recogniser::fit(const Pair* const* pairs, int count, Guess& out) {
  using Mat5 = Eigen::Matrix<double, 5, 5>;
  using Vec5 = Eigen::Matrix<double, 5, 1>;
  Mat5 H = Mat5::Zero();
  Vec5 b = Vec5::Zero();
  Mat3 S = Mat3::Zero();
  for (int i = 0; i < count; ++i) {
    const Pair& pair = *pairs[i];
    Eigen::Matrix<double, 3, 5> A = Eigen::Matrix<double, 3, 5>::Zero();
    A.col(0) = Vec3(pair.p_W.x(), pair.p_W.y(), 0);
    A.col(1) = Vec3(pair.p_W.y(), -pair.p_W.x(), 0);
    A.rightCols<3>() = -Mat3::Identity();
    const Mat3 M = Mat3::Identity() - pair.f_L * pair.f_L.transpose();
    const Eigen::Matrix<double, 5, 3> AtM = A.transpose() * M;
    H += AtM * A;
    b += AtM * (pair.c_L - Vec3(0, 0, pair.p_W.z()));
    S += M;
  }
  const Vec5 x = H.ldlt().solve(b);
  const double norm2 = x[0] * x[0] + x[1] * x[1];
  if (!x.allFinite() || std::fabs(norm2 - 1) > 2 * kNorm_tolerance) return false;
  out.cos_turn = x[0] / std::sqrt(norm2);
  out.sin_turn = x[1] / std::sqrt(norm2);
  Vec3 rhs = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    const Pair& pair = *pairs[i];
    const Vec3 d = turned_back(pair.p_W, out.cos_turn, out.sin_turn) - pair.c_L;
    rhs += d - pair.f_L * pair.f_L.dot(d);
  }
  out.s_L = S.ldlt().solve(rhs);
  return out.s_L.allFinite();
}

int Recogniser::score(const Guess& guess, bool mark) {
  int fits = 0;
  for (Pair& pair : pairs_) {
    const Vec3 d = turned_back(pair.p_W, guess.cos_turn, guess.sin_turn) - guess.s_L - pair.c_L;
    const double along = pair.f_L.dot(d), distance2 = d.squaredNorm();
    const bool good = along > kDistance_m_min && distance2 - along * along < kFit_rad2 * distance2;
    if (mark) pair.fits = good;
    fits += good ? 1 : 0;
  }
  return fits;
}

bool Recogniser::solve(const MapView& view, PlaceRule rule, const Mat3& R_WB,
                       const Tracks* const* tracks, Recognition& out, uint32_t before) {
  const int wanted = static_cast<int>(params_.recognise_matches_min);
  find_candidates(view, rule, before);
  if (static_cast<int>(candidates_.size()) < wanted) return false;
  find_pairs(view, R_WB, tracks);
  const uint32_t n = static_cast<uint32_t>(pairs_.size());
  if (static_cast<int>(n) < wanted) return false;
  RandomGenerator random;  // anew for each place
  Guess best, guess;
  int best_fits = 0;
  for (int i = 0; i < kTries; ++i) {
    const Pair* sample[kSample];
    for (const Pair*& pair : sample) pair = &pairs_[random.below(n)];
    if (!fit(sample, kSample, guess)) continue;
    const int fits = score(guess, false);
    if (fits <= best_fits) continue;
    best_fits = fits;
    best = guess;
  }
  for (int round = 0; round < 3 && best_fits >= kSample; ++round) {
    score(best, true);
    const Pair* fitting[kCamerasMax * kTracksMax];
    int count = 0;
    for (const Pair& pair : pairs_) {
      if (pair.fits) fitting[count++] = &pair;
    }
    if (fit(fitting, count, guess)) best = guess;
    best_fits = score(best, true);
  }
  if (best_fits < wanted) return false;
  Mat3 R_z;
  R_z << best.cos_turn, -best.sin_turn, 0, best.sin_turn, best.cos_turn, 0, 0, 0, 1;
  out.T_WB = {R_z * R_WB, R_z * best.s_L};
  out.matches.clear();
  for (const Pair& pair : pairs_) {
    if (!pair.fits) continue;
    out.epoch = view.point(pair.point).epoch;
    (void)out.matches.push_back({pair.camera, pair.track, view.point(pair.point).id});
  }
  return true;
}

}  // namespace pirvs
