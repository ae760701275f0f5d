// Keyframes: when one is due, which of its tracks the other camera sees, the message to mapping.
// In      poses and tracks as they are; every sample while tracking runs.
// Out     KeyframeMessage by ring; stereo pairs, which also start tracks in the other camera.
// Errors  begin: nullptr, send_start: false, nothing is sent: kKeyframeRing wait for mapping, by
//         what note_mapped() says, whatever the ring looks like meanwhile.
// Cost    ~1.2 ms a keyframe, nearly all of it the search for stereo pairs, x86-64.
// Source  PIRVS paper, section IV.C.
#pragma once

#include "modules/map/messages.h"
#include "modules/matching/stereo.h"
#include "modules/tracking/associator.h"
#include "modules/tracking/mono_start.h"
#include "modules/tracking/tracking_params.h"

namespace pirvs {

// Many methods: of messages and of pairs, a line or a few each.
class Keyframer {
 public:
  // Goes on counting.
  explicit Keyframer(const CounterArray<StereoLoss>& pairs = {}) : stereo_(pairs) {}
  void configure(const Camera* cameras, const ImuNoise& noise, const TrackerParams& params,
                 const StereoParams& stereo, KeyframeRing* ring);
  void configure_wheels(const SE3& T_BV, const WheelParams& params) {
    way_.configure(T_BV, params);
  }
  void set_noise(const ImuNoise& noise) { noise_ = noise; }
  // Motion since the last keyframe, from one sample to the next, and the wheels' speed after it.
  void integrate(const ImuSample& before, const ImuSample& now);
  void note_wheels(const WheelVelocity& velocity, bool slips) { way_.speed(velocity, slips); }

  // For the tracks of camera `c`: has the body moved far enough, or are too few of them known?
  bool due(TimeNs t, const SE3& T_WB, int c, const Associator& seen) const;
  // At rest without depth: the keyframe that a first move will be measured from is renewed.
  bool rest_due(TimeNs t) const;

  // Gives every left track its counterpart in the right image, and the reverse for tracks of known
  // points: near the projection where the point is known, along the epipolar curve where it is not.
  // T_WB nullptr: no point is known.
  void find_pairs(const SE3* T_WB, Associator& seen);
  void clear_pairs() { pairs_.clear(); }
  // What is seen now, with the stereo pairs found in it. `observations`: of kCamerasMax cameras.
  void observe(const Associator& seen, Observations* observations) const;

  // The next message, filled with `state`, what is seen and the motion so far. end() sends it.
  KeyframeMessage* begin(const BodyState& state, bool at_rest, uint16_t epoch,
                         const Associator& seen);
  void end(const KeyframeMessage& message, const BodyState& state);
  // All keyframes of a start; the next one links to the last of them.
  bool send_start(const StartKeyframes& keyframes, uint16_t epoch, const Mat6& error,
                  const Associator& seen);

  // Mapping has refined the last keyframe, or closing a loop has moved it.
  void refine(const BodyState& state);
  void move_last(const SE3& T) { move(T, last_); }
  void continue_after(uint32_t sequence) { sequence_ = mapped_ = sequence; }
  // Mapping has done all up to this keyframe.
  void note_mapped(uint32_t sequence) { mapped_ = sequence > mapped_ ? sequence : mapped_; }
  uint32_t mapped() const { return mapped_; }
  const BodyState& last() const { return last_; }
  uint32_t sent() const { return sequence_; }  // so far, the newest one's sequence
  uint32_t dropped() const { return dropped_; }
  const StereoMatcher& stereo() const { return stereo_; }
  void forget_turn() { stereo_.forget_turn(); }

 private:
  bool has_room(size_t keyframes) const {
    return sequence_ - mapped_ + keyframes <= KeyframeRing::capacity();
  }
  void begin_motion(const Vec3& b_g, const Vec3& b_a);
  void pair(int from, size_t index, const SE3* T_CW_to, Associator& seen);
  bool find_counterpart(int from, const Track& track, const SE3* T_CW_to, Associator& seen,
                        Vec2& uv_to);
  TrackId place_counterpart(int to, const Vec2& uv_to, const Track& track, LandmarkId landmark,
                            Associator& seen) const;

  Camera camera_[kCamerasMax];
  ImuNoise noise_;
  TrackerParams params_;
  KeyframeRing* ring_ = nullptr;
  StereoMatcher stereo_;
  struct StereoPair {
    TrackId left, right;
  };
  FixedVector<StereoPair, kTracksMax> pairs_;
  Preintegration since_last_;
  WheelPath way_;  // since the last keyframe
  BodyState last_;
  uint32_t sequence_ = 0, mapped_ = 0, dropped_ = 0;
};

}  // namespace pirvs
