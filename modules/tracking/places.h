// Recognises places of the map: after dead reckoning, at a start, and where a loop closes.
// In      what is seen (tracks, map), the attitude or pose as it is believed to be.
// Out     decisions as values; who asked carries them out.
// Errors  none: an answer says whether a place was found, and why a loop was not closed.
// Cost    a question ~3 ms, x86-64, and it is asked at most every recognise_every_s, loop_every_s.
// Source  recognise.h; docs/adr/0008-loops-by-the-map-error.md.
#pragma once

#include "modules/map/map_error.h"
#include "modules/matching/recognise.h"
#include "modules/tracking/associator.h"
#include "modules/tracking/filter.h"

namespace pirvs {

inline constexpr double kRecognised_rad = 0.02, kRecognised_m = 0.05;  // sigma of its pose
Mat6 error_of_sigmas(double sigma_rad, double sigma_m);
inline Mat6 recognised_error() { return error_of_sigmas(kRecognised_rad, kRecognised_m); }

enum class PlaceAnswer : uint8_t { kNotAsked, kUnknown, kFound };

struct LoopDecision {
  // kHeld: so many points are tracked that are as old that the pose stands on them already.
  enum class Verdict : uint8_t { kNone, kImplausible, kHeld, kCloses };
  Verdict verdict = Verdict::kNone;
  // kCloses: the pose is off by `off`, of covariance off_cov, since keyframe closes_to; T corrects
  // what is near.
  Vec4 off = Vec4::Zero();
  Mat4 off_cov = Mat4::Identity();
  uint32_t closes_to = 0;
  SE3 T;
};

class Places {
 public:
  void configure(const Camera* cameras, int count, const ImuNoise& noise,
                 const FilterParams& filter, const MatchingParams& matching,
                 const TrackerParams& params);
  void reset() { last_recognise_t_ = last_loop_t_ = 0; }
  // The next question is answered however soon it comes.
  void hurry() { last_recognise_t_ = 0; }

  // kFound: found() holds.
  PlaceAnswer recognise(TimeNs t, PlaceRule rule, const Mat3& R_WB, const Associator& seen);
  // Is an old place of this very map seen again, but not where it should be? kCloses: found()
  // holds. After dead reckoning from keyframe `drifted_after` on (0: there was none) any place from
  // before is old, and it may be anywhere.
  LoopDecision test_loop(TimeNs t, const SE3& T_WB, const MapError& error, uint32_t drifted_after,
                         const Associator& seen);
  const Recognition& found() const { return found_; }
  // The matched points of found() lie in one plane. Wallpaper and posters may hang in several
  // places: without a prior pose, such a match does not prove the place.
  bool found_is_planar(const Associator& seen) const;

 private:
  bool solve(PlaceRule rule, const Mat3& R_WB, const Associator& seen, uint32_t before = 0);
  void refine(const Associator& seen);
  int locate(const Associator& seen);
  bool held(const Associator& seen, uint32_t& closes_to) const;

  FilterParams filter_params_;
  TrackerParams params_;
  Recogniser recogniser_;
  Recognition found_;
  Filter locator_;
  Correspondences correspondences_;
  TimeNs last_recognise_t_ = 0, last_loop_t_ = 0;
};

}  // namespace pirvs
