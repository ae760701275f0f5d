// Tracks the body against the map: one pose per frame, never waiting for mapping.
// In      add_imu: samples in order, one of them exactly at each frame's time. prepare/frame: the
//         front-ends before and after they followed their tracks. Snapshots of the map by mailbox.
// Out     state and covariance after every sample and frame; keyframes for mapping by ring.
// Frames  W: world, z up, origin and heading of the first keyframe of a start. B: IMU. C: camera.
// Errors  none to the caller: a frame without matches moves on inertia and health says so.
// Cost    ~0.3 ms a frame, ~1.2 ms at a keyframe (stereo), x86-64.
// Source  PIRVS paper, sections IV.A to IV.C.
#pragma once

#include "core/base/counter.h"
#include "modules/frontend/frontend.h"
#include "modules/health/health.h"
#include "modules/map/map_error.h"
#include "modules/map/messages.h"
#include "modules/matching/projection.h"
#include "modules/matching/recognise.h"
#include "modules/matching/stereo.h"
#include "modules/standstill/standstill.h"
#include "modules/tracking/filter.h"
#include "modules/tracking/starter.h"

namespace pirvs {

struct TrackingParams {
  FilterParams filter;
  TrackerParams tracker;
  StereoParams stereo;
  MatchingParams matching;
  StandstillParams standstill;
  HealthParams health;
};

struct TrackingCounters {
  Counter frames, frames_with_pose, starts, start_failures, losses;
  Counter keyframes, keyframes_dropped, snapshots, snapshots_late;
  Counter matched_by_projection, standstill_frames, tracks_dropped;
  Counter recognitions, recognitions_failed, joins, loops, loops_implausible, loops_held, jumps;
  CounterArray<Gate> gates;
};

inline constexpr CounterRow<TrackingCounters> kTrackingCounters[] = {
    {"frames", &TrackingCounters::frames},
    {"frames_with_pose", &TrackingCounters::frames_with_pose},
    {"starts", &TrackingCounters::starts},
    {"start_failures", &TrackingCounters::start_failures},
    {"losses", &TrackingCounters::losses},
    {"keyframes", &TrackingCounters::keyframes},
    {"keyframes_dropped", &TrackingCounters::keyframes_dropped},
    {"snapshots", &TrackingCounters::snapshots},
    {"snapshots_late", &TrackingCounters::snapshots_late},
    {"matched_by_projection", &TrackingCounters::matched_by_projection},
    {"standstill_frames", &TrackingCounters::standstill_frames},
    {"tracks_dropped", &TrackingCounters::tracks_dropped},
    {"recognitions", &TrackingCounters::recognitions},
    {"recognitions_failed", &TrackingCounters::recognitions_failed},
    {"joins", &TrackingCounters::joins},
    {"loops", &TrackingCounters::loops},
    {"loops_implausible", &TrackingCounters::loops_implausible},
    {"loops_held", &TrackingCounters::loops_held},
    {"jumps", &TrackingCounters::jumps},
};
static_assert(every_counter_is_in(kTrackingCounters, sizeof(TrackingCounters::gates)));

struct FrameResult {
  bool has_pose = false;
  bool started = false, started_at_rest = false, health_changed = false, keyframe = false;
  bool recognised = false, joined = false, closed = false, at_rest = false;
  int correspondences = 0, accepted = 0;
};

class Tracker {
 public:
  // `cameras`: kCamerasMax of them, of which the first `count` exist.
  void configure(const Camera* cameras, int count, const ImuNoise& noise,
                 const TrackingParams& params, KeyframeRing* keyframes, MapMailbox* map);

  void add_imu(const ImuSample& sample);
  // Before the front-ends run on the frame at time t (the last sample's): takes the newest map and
  // tells every track where to look. Returns gravity in B for the descriptors.
  Vec3 prepare(Frontend* frontends);
  // After correspondences were found: associates the unmatched, a separate step so that its time
  // can be told from that of the filter.
  void match(Frontend* frontends);
  // Bit c of `present`: camera c delivered. One camera is enough for all, points then come by time.
  FrameResult frame(TimeNs t, uint8_t present, Frontend* frontends);

  // One sensor's stamps may be wrong: the next samples count little against what is seen, there are
  // no keyframes, and there is little confidence.
  void doubt_stamps(bool in_doubt) {
    in_doubt_ = in_doubt;
    health_.doubt_stamps(in_doubt);
  }

  // Time does not go on from the last sample: what runs is lost, a new start continues its place.
  void interrupt();

  uint32_t sent() const { return sequence_; }  // keyframes so far, the newest one's sequence
  bool running() const { return running_; }
  const BodyState& state() const { return filter_.state(); }
  // Against where the first start began: the filter's, which is against the map, and the map's own,
  // both cov_scale times.
  Mat15 cov() const;
  HealthState health() const { return health_.state(); }
  const Trust& trust() const { return health_.trust(); }
  const TrackingCounters& counters() const { return counters_; }
  const StereoMatcher& stereo() const { return stereo_; }

 private:
  void take_snapshot(Frontend* frontends);
  void restart_filter(const BodyState& state, const Mat15& cov);
  void note_place(const Mat6& error, const Vec3& at);
  void note_jump(const SE3& before, const SE3& after, bool certain);
  void associate(const MapSnapshot& snapshot, Frontend* frontends);
  void collect(Frontend* frontends);
  void update(TimeNs t, uint8_t seen, Frontend* frontends, FrameResult& result);
  bool recognise(TimeNs t, PlaceRule rule, const Mat3& R_WB, Frontend* frontends, Recognition& out);
  void relocalize(TimeNs t, Frontend* frontends, FrameResult& result);
  void maybe_keyframe(TimeNs t, uint8_t seen, Frontend* frontends, FrameResult& result);
  bool try_join(TimeNs t, Frontend* frontends);
  bool try_close(TimeNs t, Frontend* frontends);
  int tracked_made_by(uint32_t keyframe, const Frontend* frontends) const;
  void adopt(const Recognition& found, Frontend* frontends);
  int locate(const Recognition& found, const Frontend* frontends);
  void lose();
  Mat6 find_place(TimeNs t, Frontend* frontends);  // and how uncertain it is
  void carry_over();
  int occupied_cells() const;
  void count_misses(Frontend* frontends);
  void judge_standstill(uint8_t present, double dt_s, Frontend* frontends);
  void stand_still();
  uint8_t seeing(uint8_t present, const Frontend* frontends) const;
  void start(TimeNs t, uint8_t seen, Frontend* frontends, FrameResult& result);
  Status try_start(TimeNs t, uint8_t seen, Frontend* frontends);
  bool send_start(const Mat6& error);
  bool keyframe_due(TimeNs t, int c, const Frontend& frontend) const;
  bool rest_keyframe_due(TimeNs t) const;
  void find_stereo(Frontend* frontends);
  void observe(const Frontend* frontends, Observations* observations) const;
  KeyframeMessage* begin_keyframe(TimeNs t, Frontend* frontends);
  void end_keyframe(const KeyframeMessage& message);

  Camera camera_[kCamerasMax];
  int cameras_ = kCamerasMax;
  ImuNoise noise_;
  TrackingParams params_;
  KeyframeRing* keyframes_ = nullptr;
  MapMailbox* mailbox_ = nullptr;

  Filter filter_, locator_;
  Starter starter_;
  StereoMatcher stereo_;
  Health health_;
  StandstillDetector standstill_;
  bool holding_ = false;  // at rest: at the last frame the filter was at rest_state_ with rest_cov_
  BodyState rest_state_;
  Mat15 rest_cov_ = Mat15::Zero();
  MapView view_;
  LandmarkTable landmarks_[kCamerasMax];
  TrackTable<uint8_t> misses_[kCamerasMax];  // consecutive images that gated the landmark out
  bool running_ = false;
  bool in_doubt_ = false;
  uint8_t start_cameras_ = 0;         // that the attempt to start looks through, a bit each
  TimeNs last_pair_t_ = 0;            // when both cameras last saw something
  SE3 origin_;                        // where a restart continues
  Mat6 origin_error_ = Mat6::Zero();  // of that
  TimeNs origin_t_ = 0;
  Mat6 map_error_ = Mat6::Zero();  // of the map about map_error_at_
  Vec3 map_error_at_ = Vec3::Zero();
  SE3 T_WB_last_frame_;  // for flow prediction
  TimeNs last_frame_t_ = 0;
  Preintegration since_keyframe_;
  BodyState last_keyframe_;
  uint32_t sequence_ = 0;
  uint16_t epoch_ = 0, epochs_ = 0;  // of the keyframes now; the last that was given out
  bool place_known_ = true;          // this epoch is the map's first, or was joined to it
  TimeNs last_recognise_t_ = 0, last_loop_t_ = 0;
  TimeNs light_since_ = 0;  // blind no longer, but the place not yet recognised; 0: neither
  bool located_ = false;    // matches have been enough since the start
  bool joining_ = false;    // mapping carries this epoch over to another by T_join_
  SE3 T_join_;
  Recogniser recogniser_;
  Recognition recognition_;
  ImuSample last_imu_;
  bool has_imu_ = false;
  Mat3 R_BlBn_ = Mat3::Identity();  // gyro alone, last frame to now, while starting

  static constexpr size_t kHistory = 1024;  // 5 s at 200 Hz
  ImuSample history_[kHistory];
  size_t history_size_ = 0;  // samples ever stored; the newest is at (size - 1) % kHistory

  struct Pair {
    TrackId left, right;
  };
  FixedVector<Pair, kTracksMax> stereo_pairs_;
  Correspondences correspondences_;
  FixedVector<const Track*, kCamerasMax * kTracksMax> corresponding_;  // tracks of correspondences_
  Observations start_observations_[kCamerasMax];
  TrackingCounters counters_;
};

}  // namespace pirvs
