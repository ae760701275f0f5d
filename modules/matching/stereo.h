// Finds where points of one camera lie in the other: a scan along the epipolar curve, then flow.
// In      pyramids of both cameras, a point in camera `from`, an interval of inverse depth.
// Out     the point in camera `to`, sub-pixel, distorted pixels.
// Frames  C0, C1; T_C1C0 from the calibration.
// Errors  a named, counted rejection (StereoLoss).
// Cost    ~8 us a point on x86-64, of which half is the scan.
// Source  PIRVS paper, section IV.C ("search for spatial correspondences using epipolar
//         constraint").
#pragma once

#include <iterator>

#include "core/base/counter.h"
#include "core/camera/camera.h"
#include "core/params/params.h"
#include "modules/frontend/pyramid_store.h"
#include "modules/frontend/track.h"
#include "modules/matching/epipolar_turn.h"

namespace pirvs {

enum class StereoLoss : uint8_t {
  kFound,
  kOutside,
  kNoTexture,
  kAmbiguous,
  kFlow,
  kResidual,
  kEpipolar,
  kReturn,
  kCount
};
const char* name(StereoLoss loss);

struct StereoParams {
  float depth_m_min = 0.35f;
  float zssd_grey2_max = 600.0f;
  float ambiguity_ratio_max = 0.8f;
  float residual_grey_max = 18.0f;
  float epipolar_px_max = 1.5f;
  float return_px_max = 1.0f;
};

inline constexpr ParamRow<StereoParams> kStereoRows[] = {
    {"depth_m_min", &StereoParams::depth_m_min, 0.05f, 5, "m", Audience::kUser,
     "depth of the nearest point that stereo matching searches for"},
    {"zssd_grey2_max", &StereoParams::zssd_grey2_max, 1, 10000, "grey^2", Audience::kExpert,
     "largest mean squared difference, means removed, of a match on the epipolar curve"},
    {"ambiguity_ratio_max", &StereoParams::ambiguity_ratio_max, 0.1f, 1, "1", Audience::kExpert,
     "ratio test: largest quotient of the best and the second best match on the epipolar curve"},
    {"residual_grey_max", &StereoParams::residual_grey_max, 1, 128, "grey", Audience::kExpert,
     "largest mean absolute difference of the patches after optical flow"},
    {"epipolar_px_max", &StereoParams::epipolar_px_max, 0.1f, 10, "px", Audience::kExpert,
     "largest distance of a match from the epipolar curve"},
    {"return_px_max", &StereoParams::return_px_max, 0.05f, 10, "px", Audience::kExpert,
     "left-right check: largest distance to where flow back to the first camera should end"},
};
static_assert(sizeof(StereoParams) == std::size(kStereoRows) * sizeof(float));
static_assert(in_range(StereoParams{}, kStereoRows));

class StereoMatcher {
 public:
  explicit StereoMatcher(const CounterArray<StereoLoss>& counted = {}) : losses_(counted) {}
  void configure(const Camera& c0, const Camera& c1, const StereoParams& params);
  // Searches all depths from params.depth_m_min to infinity.
  StereoLoss find(int from, const PyramidStore& image_from, const PyramidStore& image_to,
                  const Vec2& uv_from, Vec2& uv_to);
  // Searches near a known place only (a landmark's projection).
  StereoLoss find_near(int from, const PyramidStore& image_from, const PyramidStore& image_to,
                       const Vec2& uv_from, const Vec2& uv_expected, Vec2& uv_to);
  const CounterArray<StereoLoss>& losses() const { return losses_; }
  // Where hardly a track lies on its curve: which look alike, wherever, tells how far off it is.
  void compare_looks(const Tracks& left, const Tracks& right);
  // Of what was found from the left, how far off its epipolar curve it may be.
  const EpipolarTurn& turn() const { return turn_; }
  void forget_turn() { turn_.forget(); }

 private:
  // What the scan leaves: the best place, and another that may be as good between two steps.
  struct Scanned {
    Vec2 best, rival;
    bool rivalled = false;
  };
  StereoLoss scan(int from, const PyramidStore& image_from, const PyramidStore& image_to,
                  const Vec2& uv_from, Scanned& out) const;
  StereoLoss refine(int from, const PyramidStore& image_from, const PyramidStore& image_to,
                    const Vec2& uv_from, Vec2& uv_to, float& residual);
  StereoLoss count(StereoLoss loss);

  Camera camera_[kCamerasMax];
  SE3 T_to_from_[kCamerasMax];  // index: from
  StereoParams params_;
  EpipolarTurn turn_;
  CounterArray<StereoLoss> losses_;
};

}  // namespace pirvs
