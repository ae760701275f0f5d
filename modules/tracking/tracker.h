// Tracks the body against the map: one pose per frame, never waiting for mapping.
// In      add_imu: samples in order, one of them exactly at each frame's time. add_wheel: what the
//         wheels tell, between them. prepare before and
//         match, frame after the front-ends followed their tracks. Snapshots of the map by mailbox.
// Out     state and covariance after every sample and frame; keyframes for mapping by ring.
// Frames  W: world, z up, origin and heading of the first keyframe of a start. B: IMU. C: camera.
// Errors  none to the caller: a frame without matches moves on inertia and health says so.
// Cost    ~0.3 ms a frame, ~1.2 ms at a keyframe (stereo), x86-64. All methods on one core; the
//         front-ends run between prepare and match, wherever.
// Source  PIRVS paper, sections IV.A to IV.C.
#pragma once

#include "core/base/counter.h"
#include "modules/frontend/frontend.h"
#include "modules/health/health.h"
#include "modules/imu/imu_history.h"
#include "modules/imu/vibration.h"
#include "modules/map/map_error.h"
#include "modules/map/messages.h"
#include "modules/matching/stereo.h"
#include "modules/standstill/standstill.h"
#include "modules/tracking/associator.h"
#include "modules/tracking/estimate.h"
#include "modules/tracking/initializer.h"
#include "modules/tracking/keyframer.h"
#include "modules/tracking/places.h"
#include "modules/tracking/turn_check.h"

namespace pirvs {

struct TrackingParams {
  FilterParams filter;
  TrackerParams tracker;
  StereoParams stereo;
  MatchingParams matching;
  StandstillParams standstill;
  HealthParams health;
  WheelParams wheels;
};

struct TrackingCounters {
  Counter frames, frames_with_pose, starts, start_failures, losses, losses_hopeless;
  Counter keyframes, keyframes_dropped, snapshots, snapshots_late;
  Counter matched_by_projection, standstill_frames, tracks_dropped;
  Counter recognitions, recognitions_failed, recognitions_implausible, disagreements, joins, loops,
      loops_implausible, loops_held, jumps, cameras_left_out;
  Counter wheels_used, wheels_slipping, wheels_skidding, wheels_refused;
  CounterArray<Gate> gates;
};

inline constexpr CounterRow<TrackingCounters> kTrackingCounters[] = {
    {"frames", &TrackingCounters::frames},
    {"frames_with_pose", &TrackingCounters::frames_with_pose},
    {"starts", &TrackingCounters::starts},
    {"start_failures", &TrackingCounters::start_failures},
    {"losses", &TrackingCounters::losses},
    {"losses_hopeless", &TrackingCounters::losses_hopeless},
    {"keyframes", &TrackingCounters::keyframes},
    {"keyframes_dropped", &TrackingCounters::keyframes_dropped},
    {"snapshots", &TrackingCounters::snapshots},
    {"snapshots_late", &TrackingCounters::snapshots_late},
    {"matched_by_projection", &TrackingCounters::matched_by_projection},
    {"standstill_frames", &TrackingCounters::standstill_frames},
    {"tracks_dropped", &TrackingCounters::tracks_dropped},
    {"recognitions", &TrackingCounters::recognitions},
    {"recognitions_failed", &TrackingCounters::recognitions_failed},
    {"recognitions_implausible", &TrackingCounters::recognitions_implausible},
    {"disagreements", &TrackingCounters::disagreements},
    {"joins", &TrackingCounters::joins},
    {"loops", &TrackingCounters::loops},
    {"loops_implausible", &TrackingCounters::loops_implausible},
    {"loops_held", &TrackingCounters::loops_held},
    {"jumps", &TrackingCounters::jumps},
    {"cameras_left_out", &TrackingCounters::cameras_left_out},
    {"wheels_used", &TrackingCounters::wheels_used},
    {"wheels_slipping", &TrackingCounters::wheels_slipping},
    {"wheels_skidding", &TrackingCounters::wheels_skidding},
    {"wheels_refused", &TrackingCounters::wheels_refused},
};
static_assert(every_counter_is_in(kTrackingCounters, sizeof(TrackingCounters::gates)));

struct FrameResult {
  bool has_pose = false;
  bool started = false, started_at_rest = false, health_changed = false, keyframe = false;
  bool recognised = false, joined = false, closed = false, at_rest = false;
  int correspondences = 0, accepted = 0;
};

// Many methods: the one door to tracking; half of them answer in one line.
class Tracker {
 public:
  Tracker() = default;
  // Goes on counting.
  Tracker(const TrackingCounters& counted, const CounterArray<StereoLoss>& pairs)
      : keyframer_(pairs), counters_(counted) {}
  // Called again: other parameters from now on; what is tracked goes on, an attempt to start begins
  // anew. `cameras` and `frontends`: kCamerasMax of them, of which the first `count` exist.
  // Front-ends, ring and mailbox stay the caller's and outlive the tracker.
  void configure(const Camera* cameras, int count, const ImuNoise& noise,
                 const TrackingParams& params, Frontend* frontends, KeyframeRing* keyframes,
                 MapMailbox* map);
  // The vehicle whose wheels speak; none by default.
  void configure_wheels(const WheelCalibration& wheels);

  // Everything but what has been counted; configure() is next.
  void forget();

  void add_imu(const ImuSample& sample);
  // After the IMU sample before it.
  void add_wheel(const WheelSample& sample);
  // Before the front-ends run on the frame at time t (the last sample's): takes the newest map and
  // tells every track where to look. `finished`: the newest keyframe that mapping has done. Returns
  // gravity in B for the descriptors.
  Vec3 prepare(uint32_t finished);
  // After correspondences were found: associates the unmatched, a separate step so that its time
  // can be told from that of the filter.
  void match();
  // Bit c of `present`: camera c delivered. One camera is enough for all, points then come by time.
  FrameResult frame(TimeNs t, uint8_t present);

  // One sensor's stamps may be wrong: the next samples count little against what is seen, there are
  // no keyframes, and there is little confidence.
  void doubt_stamps(bool in_doubt) {
    in_doubt_ = in_doubt;
    health_.doubt_stamps(in_doubt);
  }

  // Time does not go on from the last sample: what runs is lost, a new start continues its place.
  void interrupt();

  // W is moved by T, a turn about the vertical and a shift; mapping has done the same and published
  // it. Counts as a jump.
  void move_world(const SE3& T);
  // The mailbox holds a map of an earlier run, whose newest keyframe is `sequence` and newest epoch
  // `epoch`: a start looks for its place there. Before any start.
  void continue_map(uint32_t sequence, uint16_t epoch);
  bool has_loaded_map() const { return epochs_loaded_ != 0; }
  // A hint: the body is near T_WB in the loaded map. Tracking starts again from there, with an
  // uncertainty of sigma_m.
  void continue_at(TimeNs t, const SE3& T_WB, double sigma_m);

  uint32_t sent() const { return keyframer_.sent(); }  // keyframes so far, the newest's sequence
  bool running() const { return running_; }
  uint16_t epoch() const { return pose_epoch_; }  // of the pose that is given out
  // The pose stands in the frame of the map that was loaded.
  bool in_map() const { return running_ && pose_epoch_ != 0 && pose_epoch_ <= epochs_loaded_; }
  const BodyState& state() const { return estimate_.state(); }
  // Up to which keyframe mapping had come when the frame in work began: what the frame depends on
  // besides its input. While tracking runs, the keyframe of its map.
  uint32_t mapped() const { return keyframer_.mapped(); }
  bool at_rest() const { return standstill_.at_rest(); }
  // Cameras whose images a frame at t is to do without, a bit each: those that disagree.
  uint8_t left_out(TimeNs t) const { return pair_check_.left_out(t); }
  // The pose, or where a start would continue.
  const SE3& place() const { return running_ ? state().T_WB : initializer_.origin(); }
  Mat15 cov() const { return estimate_.cov(); }
  HealthState health() const { return health_.state(); }
  const Trust& trust() const { return health_.trust(); }
  // By how much the cameras' stamps are to be taken for later from now on, ns; 0 unless
  // tracker.estimate_time.
  TimeNs correct_time();
  SelfCalibration::Estimate self_calibration() const {
    return estimate_.self_calibration().estimate();
  }
  double wheel_scale() const { return odometry_.scale(); }
  const TrackingCounters& counters() const { return counters_; }
  const StereoMatcher& stereo() const { return keyframer_.stereo(); }
  // Of the last frame.
  const Tracks& tracks(int c) const { return associator_.tracks(c); }
  TrackUse use(int c, const Track& track) const { return associator_.use(c, track); }
  // The landmarks that tracks show, each once. Returns the count.
  int seen_points(SeenPoint* out, int max) const { return associator_.seen_points(out, max); }

 private:
  void take_snapshot();
  void fuse_again(const MapSnapshot& snapshot);
  void advance_to_now();
  void note_recent(TimeNs t, uint8_t present, bool at_rest);
  void follow_level(const SE3& leveled);
  void update(TimeNs t, uint8_t seen, FrameResult& result);
  int fuse(Correspondences& correspondences);
  FrameEvidence evidence(TimeNs t, const FrameResult& result, int cells) const;
  void compare_cameras(TimeNs t, const Correspondences& correspondences);
  bool leave_out_turned(TimeNs t);
  void compare_turns(TimeNs t, uint8_t present, double dt_s);
  void relocalize(TimeNs t, FrameResult& result);
  bool recognise(TimeNs t, PlaceRule rule, const Mat3& R_WB);
  void note_jump(const SE3& before, const SE3& after, bool certain);
  void lose();
  void start(TimeNs t, uint8_t seen, FrameResult& result);
  void maybe_keyframe(TimeNs t, uint8_t seen, FrameResult& result);
  bool try_join(TimeNs t);
  bool try_close(TimeNs t);

  TrackingParams params_;
  MapMailbox* mailbox_ = nullptr;

  PairCheck pair_check_;
  TurnCheck turn_check_;
  ImuHistory history_;
  ImuNoise noise_;            // of an IMU that nothing shakes
  VibrationMeter vibration_;  // and what does
  WheelOdometry odometry_;
  WheelHistory wheels_;
  TimeNs slips_until_ = 0;
  StandstillDetector standstill_;
  Associator associator_;
  Estimate estimate_;
  Places places_;
  RecentFrames recent_;  // since rest or a start
  Keyframer keyframer_;
  Initializer initializer_;
  Health health_;

  Vec3 force_B_ = Vec3::Zero();  // the newest, whatever was interrupted since: which way is up
  bool running_ = false;
  bool in_doubt_ = false;
  TimeNs last_frame_t_ = 0;
  uint16_t epoch_ = 0, epochs_ = 0;  // of the keyframes now; the last that was given out
  uint16_t epochs_loaded_ = 0;       // those of the map that was loaded
  uint16_t pose_epoch_ = 0;  // of the published pose; follows epoch_ once mapping has joined
  bool place_known_ = true;  // this epoch is the map's first, or was joined to it
  TimeNs light_since_ = 0;   // images are usable again, the place is not recognised yet; 0: not so
  BodyState begin_;          // as the last start left it
  Mat6 begin_error_ = Mat6::Zero();
  bool located_ = false;     // matches have been enough since the start
  bool searching_ = false;   // after dead reckoning: what matches has to agree before it counts
  bool drift_told_ = false;  // to mapping, since then
  // The newest keyframe before the last dead reckoning whose drift no loop has closed; 0: none.
  uint32_t drifted_after_ = 0;
  bool joining_ = false;  // mapping carries this epoch over to another by T_join_
  SE3 T_join_;
  TrackingCounters counters_;
};

}  // namespace pirvs
