#include "modules/matching/stereo.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/Geometry>

#include "core/kernels/hamming/hamming.h"
#include "core/kernels/lk/lk.h"
#include "core/kernels/zssd/zssd.h"
#include "modules/matching/matching_params.h"

namespace pirvs {
namespace {

constexpr int kScanLevel = 1;  // half size: the scan needs a place to within flow's reach only
constexpr int kScanStepsMax = 192;
constexpr int kPatch = 8;  // side of the scanned patch at kScanLevel
// Largest quotient of the residuals of a match and of its rival: on a pattern that repeats itself
// they differ by noise, of which 16 x 16 pixels leave a twentieth.
constexpr float kAlike = 0.7f;

// Flow from `uv_to`, which is moved.
StereoLoss align(const PyramidStore& image_from, const PyramidStore& image_to, const Vec2& uv_from,
                 Vec2& uv_to, float& residual) {
  float x = static_cast<float>(uv_to.x()), y = static_cast<float>(uv_to.y());
  const float x0 = static_cast<float>(uv_from.x()), y0 = static_cast<float>(uv_from.y());
  LkPatch patch;
  for (int l = kScanLevel; l >= 0; --l) {
    const float scale = 1.0f / static_cast<float>(1 << l);
    float xl = x * scale, yl = y * scale;
    if (!lk_extract(image_from.level(l), x0 * scale, y0 * scale, patch) || !patch.usable) {
      if (l == 0) return StereoLoss::kNoTexture;
      continue;
    }
    if (lk_align(image_to.level(l), patch, xl, yl, 10, 0.02f, residual)) {
      x = xl / scale;
      y = yl / scale;
    } else if (l == 0) {
      return StereoLoss::kFlow;
    }
  }
  uv_to = Vec2(x, y);
  return StereoLoss::kFound;
}

}  // namespace

const char* name(StereoLoss loss) {
  static constexpr const char* kNames[] = {
      "stereo_found", "stereo_outside",  "stereo_no_texture", "stereo_ambiguous",
      "stereo_flow",  "stereo_residual", "stereo_epipolar",   "stereo_return"};
  static_assert(std::size(kNames) == static_cast<size_t>(StereoLoss::kCount));
  return kNames[static_cast<size_t>(loss)];
}

void StereoMatcher::configure(const Camera& c0, const Camera& c1, const StereoParams& params) {
  camera_[0] = c0;
  camera_[1] = c1;
  T_to_from_[0] = c1.T_BC.inverse() * c0.T_BC;
  T_to_from_[1] = T_to_from_[0].inverse();
  params_ = params;
  turn_.configure(c0, c1);
}

StereoLoss StereoMatcher::find(int from, const PyramidStore& image_from,
                               const PyramidStore& image_to, const Vec2& uv_from, Vec2& uv_to) {
  Scanned scanned;
  StereoLoss loss = scan(from, image_from, image_to, uv_from, scanned);
  if (loss != StereoLoss::kFound) return count(loss);
  uv_to = scanned.best;
  float residual = 0, rival = 0;
  loss = refine(from, image_from, image_to, uv_from, uv_to, residual);
  const bool rivalled =
      loss == StereoLoss::kFound && scanned.rivalled &&
      align(image_from, image_to, uv_from, scanned.rival, rival) == StereoLoss::kFound &&
      residual >= kAlike * rival && (scanned.rival - uv_to).norm() > params_.return_px_max;
  return count(rivalled ? StereoLoss::kAmbiguous : loss);
}

StereoLoss StereoMatcher::find_near(int from, const PyramidStore& image_from,
                                    const PyramidStore& image_to, const Vec2& uv_from,
                                    const Vec2& uv_expected, Vec2& uv_to) {
  uv_to = uv_expected;
  float residual = 0;
  return count(refine(from, image_from, image_to, uv_from, uv_to, residual));
}

// Disparity is linear in inverse depth, so equal steps of it are equal steps in the image.
StereoLoss StereoMatcher::scan(int from, const PyramidStore& image_from,
                               const PyramidStore& image_to, const Vec2& uv_from,
                               Scanned& out) const {
  const int to = 1 - from;
  const ImageView& source = image_from.level(kScanLevel);
  const ImageView& target = image_to.level(kScanLevel);
  const double scale = 1.0 / (1 << kScanLevel);
  const auto corner_of = [&](const Vec2& uv, const ImageView& im, int& x, int& y) {
    x = static_cast<int>(std::floor(uv.x() * scale + 0.5)) - kPatch / 2;
    y = static_cast<int>(std::floor(uv.y() * scale + 0.5)) - kPatch / 2;
    return x >= 0 && y >= 0 && x + kPatch <= im.width && y + kPatch <= im.height;
  };
  int sx, sy;
  Vec3 bearing;
  if (!corner_of(uv_from, source, sx, sy)) return StereoLoss::kOutside;
  if (!camera_[from].unproject(uv_from, bearing)) return StereoLoss::kOutside;
  const SE3& T = T_to_from_[from];
  const Vec3 ray = T.R * bearing;
  const double rho_max = 1.0 / params_.depth_m_min;
  Vec2 near_uv, far_uv;
  if (!camera_[to].project(ray, far_uv)) return StereoLoss::kOutside;
  if (!camera_[to].project(ray + T.p * rho_max, near_uv)) return StereoLoss::kOutside;
  const int steps =
      std::min(kScanStepsMax, 2 + static_cast<int>((near_uv - far_uv).norm() * scale));

  const uint8_t* patch = source.row(sy) + sx;
  uint32_t cost[kScanStepsMax + 1];
  Vec2 place[kScanStepsMax + 1];
  int best = -1;
  for (int i = 0; i <= steps; ++i) {
    cost[i] = UINT32_MAX;
    int x, y;
    if (!camera_[to].project(ray + T.p * (rho_max * i / steps), place[i])) continue;
    if (!corner_of(place[i], target, x, y)) continue;
    cost[i] = zssd_8x8(patch, source.stride, target.row(y) + x, target.stride);
    if (best < 0 || cost[i] < cost[best]) best = i;
  }
  if (best < 0) return StereoLoss::kOutside;
  if (static_cast<float>(cost[best]) > params_.zssd_grey2_max * kPatch * kPatch) {
    return StereoLoss::kNoTexture;
  }
  int second = -1;
  for (int i = 0; i <= steps; ++i) {
    if (std::abs(i - best) > 3 && (second < 0 || cost[i] < cost[second])) second = i;
  }
  out.best = place[best];
  out.rivalled = false;
  if (second < 0 || cost[second] == UINT32_MAX) return StereoLoss::kFound;
  if (cost[second] == 0) return StereoLoss::kNoTexture;  // flat, or an exact repeat
  if (static_cast<float>(cost[best]) >=
      params_.ambiguity_ratio_max * static_cast<float>(cost[second])) {
    return StereoLoss::kAmbiguous;
  }
  // Between two steps it may be as good: it is no worse than the best one is a step aside.
  const uint32_t aside = std::max(best > 0 ? cost[best - 1] : 0, best < steps ? cost[best + 1] : 0);
  out.rivalled = cost[second] <= aside;
  out.rival = place[second];
  return StereoLoss::kFound;
}

// Aligned, and then the way back ends where it began, and the match lies on its epipolar curve.
StereoLoss StereoMatcher::refine(int from, const PyramidStore& image_from,
                                 const PyramidStore& image_to, const Vec2& uv_from, Vec2& uv_to,
                                 float& residual) {
  const StereoLoss loss = align(image_from, image_to, uv_from, uv_to, residual);
  if (loss != StereoLoss::kFound) return loss;
  if (residual > params_.residual_grey_max) return StereoLoss::kResidual;
  const float x0 = static_cast<float>(uv_from.x()), y0 = static_cast<float>(uv_from.y());
  const float x = static_cast<float>(uv_to.x()), y = static_cast<float>(uv_to.y());
  LkPatch patch;
  float back_x = x0, back_y = y0, back_residual = 0;
  if (!lk_extract(image_to.level(0), x, y, patch) || !patch.usable) return StereoLoss::kOutside;
  if (!lk_align(image_from.level(0), patch, back_x, back_y, 4, 0.02f, back_residual)) {
    return StereoLoss::kReturn;
  }
  const float dx = back_x - x0, dy = back_y - y0;
  if (dx * dx + dy * dy > params_.return_px_max * params_.return_px_max) return StereoLoss::kReturn;

  // Distance from the epipolar curve, in pixels of the image it was found in.
  Vec3 f_from, f_to;
  if (!camera_[from].unproject(uv_from, f_from) || !camera_[1 - from].unproject(uv_to, f_to)) {
    return StereoLoss::kOutside;
  }
  if (from == 0) turn_.add(f_from, f_to);
  const SE3& T = T_to_from_[from];
  const Vec3 normal = T.p.cross(T.R * f_from);
  const double sine_off_plane = f_to.dot(normal) / (normal.norm() + 1e-12);
  if (std::fabs(sine_off_plane) * camera_[1 - from].fx > params_.epipolar_px_max) {
    return StereoLoss::kEpipolar;
  }
  return StereoLoss::kFound;
}

void StereoMatcher::compare_looks(const Tracks& left, const Tracks& right) {
  constexpr MatchingParams kLooks;
  FixedVector<const Track*, kTracksMax> others;
  FixedVector<Descriptor, kTracksMax> descriptors;
  for (const Track& track : right) {
    if (!track.described) continue;
    (void)others.push_back(&track);
    (void)descriptors.push_back(track.descriptor);
  }
  FixedVector<EpipolarTurn::Look, kTracksMax> looks;
  for (const Track& track : left) {
    if (!track.described) continue;
    int best, distance, second;
    hamming_best(track.descriptor, descriptors.data(), static_cast<int>(descriptors.size()), best,
                 distance, second);
    if (best < 0 || !is_match(kLooks, distance, second)) continue;
    const Track& other = *others[static_cast<size_t>(best)];
    EpipolarTurn::Look look;
    if (!camera_[0].unproject(Vec2(track.x, track.y), look.f_C0)) continue;
    if (!camera_[1].unproject(Vec2(other.x, other.y), look.f_C1)) continue;
    look.f_C0.normalize();
    look.f_C1.normalize();
    (void)looks.push_back(look);
  }
  turn_.add_looks(looks.data(), static_cast<int>(looks.size()));
}

StereoLoss StereoMatcher::count(StereoLoss loss) {
  losses_.add(loss);
  return loss;
}

}  // namespace pirvs
