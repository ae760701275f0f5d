// Tracks the body against the map: one pose per frame, never waiting for mapping.
// In      add_imu: samples in order, one of them exactly at each frame's time. prepare/frame: the
//         front-ends before and after they followed their tracks. Snapshots of the map by mailbox.
// Out     state and covariance after every sample and frame; keyframes for mapping by ring.
// Frames  W: world, z up, origin and heading of the first keyframe of a start. B: IMU. C: camera.
// Errors  none to the caller: a frame without matches moves on inertia and health says so.
// Cost    ~0.3 ms a frame, ~1.2 ms at a keyframe (stereo), x86-64.
// Source  PIRVS paper, sections IV.A to IV.C.
#pragma once

#include "core/store/mailbox.h"
#include "core/store/ring.h"
#include "modules/frontend/frontend.h"
#include "modules/health/health.h"
#include "modules/matching/projection.h"
#include "modules/matching/stereo.h"
#include "modules/tracking/filter.h"
#include "modules/tracking/starter.h"

namespace pirvs {

inline constexpr size_t kKeyframeRing = Starter::kKeyframesMax + 2;  // a whole start, and slack
using KeyframeRing = Ring<KeyframeMessage, kKeyframeRing>;
using MapMailbox = Mailbox<MapSnapshot>;

struct TrackingParams {
  FilterParams filter;
  TrackerParams tracker;
  StereoParams stereo;
  HealthParams health;
};

struct TrackingCounters {
  uint32_t frames = 0, frames_with_pose = 0, starts = 0, start_failures = 0, losses = 0;
  uint32_t keyframes = 0, keyframes_dropped = 0, snapshots = 0, snapshots_late = 0;
  uint32_t matched_by_projection = 0, standstill_frames = 0, tracks_dropped = 0;
  uint32_t gates[static_cast<int>(Gate::kCount)] = {};
};

struct FrameResult {
  bool has_pose = false;
  bool started = false, started_at_rest = false, health_changed = false, keyframe = false;
  int correspondences = 0, accepted = 0;
};

class Tracker {
 public:
  void configure(const Camera* cameras, const ImuNoise& noise, const TrackingParams& params,
                 KeyframeRing* keyframes, MapMailbox* map);

  void add_imu(const ImuSample& sample);
  // Before the front-ends run on the frame at time t (the last sample's): takes the newest map and
  // tells every track where to look. Returns gravity in B for the descriptors.
  Vec3 prepare(Frontend* frontends);
  // After correspondences were found: associates the unmatched, a separate step so that its time
  // can be told from that of the filter.
  void match(Frontend* frontends);
  // `stereo`: both cameras delivered. Without, the frame is tracked but never becomes a keyframe.
  FrameResult frame(TimeNs t, bool stereo, Frontend* frontends);

  // Time does not go on from the last sample: what runs is lost, a new start continues its place.
  void interrupt();

  uint32_t sent() const { return sequence_; }  // keyframes so far, the newest one's sequence
  bool running() const { return running_; }
  const BodyState& state() const { return filter_.state(); }
  const Mat15& cov() const { return filter_.cov(); }
  HealthState health() const { return health_.state(); }
  const TrackingCounters& counters() const { return counters_; }
  const StereoMatcher& stereo() const { return stereo_; }

 private:
  void take_snapshot(Frontend* frontends);
  void restart_filter(const BodyState& state, const Mat15& cov);
  void associate(const MapSnapshot& snapshot, Frontend* frontends);
  void collect(Frontend* frontends);
  void count_misses(Frontend* frontends);
  double image_motion(const Frontend& frontend) const;
  void lose();
  void start(TimeNs t, Frontend* frontends, FrameResult& result);
  bool keyframe_due(TimeNs t, const Frontend* frontends) const;
  void find_stereo(Frontend* frontends);
  void observe(const Frontend* frontends, Observations* observations) const;
  void send_keyframe(TimeNs t, Frontend* frontends);

  Camera camera_[kCamerasMax];
  ImuNoise noise_;
  TrackingParams params_;
  KeyframeRing* keyframes_ = nullptr;
  MapMailbox* mailbox_ = nullptr;

  Filter filter_;
  Starter starter_;
  StereoMatcher stereo_;
  Health health_;
  StandstillDetector standstill_;
  MapView view_;
  bool running_ = false;
  SE3 origin_;           // where a restart continues
  SE3 T_WB_last_frame_;  // for flow prediction
  TimeNs last_frame_t_ = 0;
  Mat3 R_B0B_last_ = Mat3::Identity();
  Preintegration since_keyframe_;
  BodyState last_keyframe_;
  uint32_t sequence_ = 0;
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
  FixedVector<Track*, kCamerasMax * kTracksMax> corresponding_;  // tracks of correspondences_
  Observations start_observations_[kCamerasMax];
  TrackingCounters counters_;
};

}  // namespace pirvs
