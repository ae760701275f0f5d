// What    All that a page can show, gathered from a device, a replay or a finished run.
// In      What the source tells, from any thread; each call copies and returns.
// Out     all(): what a page needs that has just come. news(): what has been told since the last
//         news(). Both from the server's thread, which encodes; no source waits for that.
// Frames  W, B, E as everywhere (docs/conventions.md).
// Units   m, rad, s; ns on the source's clock, but host_t: on this machine's (bsp::now()).
// Errors  none. What is told lasts up to a bound: kPathMax places, kPointsMax points, kEventsMax
//         events; then every other place, or the oldest, are given up.
// Cost    A pose 0.2 us for its source; ~20 us of the server's thread for each of its rounds.
// Source  docs/view.md.
#pragma once

#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "modules/fusion/fix_check.h"
#include "modules/fusion/fused_pose.h"
#include "modules/health/health.h"
#include "modules/tracking/associator.h"
#include "tools/view/message.h"

namespace pirvs::tools {

struct ViewPose {
  TimeNs t = 0, host_t = 0;
  TimeNs t_published = 0, t_frame = 0;  // t_published 0: not known
  Vec3 p_WB = Vec3::Zero(), v_WB = Vec3::Zero(), w_B = Vec3::Zero();
  Vec4 q_xyzw = Vec4(0, 0, 0, 1);
  Vec3 sigma_theta = Vec3::Zero(), sigma_p = Vec3::Zero(), sigma_v = Vec3::Zero();
  HealthState health = HealthState::kInitializing;
  float confidence = 0, jump_m = 0;
  uint32_t resets = 0;
  uint16_t epoch = 0, reasons = 0;
  bool dead_reckoning = false;
  bool in_map = false;  // the pose stands in the frame of a map that was loaded
};

// What tracking did with a frame; a device does not tell it.
struct ViewFrame {
  TimeNs t = 0;
  HealthState health = HealthState::kInitializing;
  bool has_pose = false, keyframe = false, at_rest = false;
  Vec3 p_WB = Vec3::Zero();
  Vec4 q_xyzw = Vec4(0, 0, 0, 1);
  int tracks[2] = {0, 0};
  int correspondences = 0, accepted = 0;
  float image_ms = 0, matching_ms = 0, tracking_ms = 0, mapping_ms = 0, total_ms = 0;
};

struct ViewPoint {
  uint32_t id = 0;
  Eigen::Vector3f p_W = Eigen::Vector3f::Zero();
  float sigma_m = 0;
};

struct ViewTrack {
  float x = 0, y = 0, age = 0, use = 0;  // pixels of the whole image; images; a TrackUse
};

struct ViewImage {
  TimeNs t = 0;
  int camera = 0;
  int width = 0, height = 0;  // of the camera's image, which may have been made smaller
  std::string jpeg;
  std::vector<ViewTrack> tracks;
};

// Many methods: one for each thing that a source tells.
class ViewScene {
 public:
  static constexpr size_t kPathMax = 40'000, kPointsMax = 60'000, kEventsMax = 500;

  // ---- the source ----
  // "source" of the message hello; forgets all that was told of another.
  void begin(const nlohmann::json& source);
  // connected, waiting, ended; and a line about it.
  void source_is(const char* state, const std::string& what);
  void pose(const ViewPose& pose);
  void frame(const ViewFrame& frame);
  void keyframe(const Vec3& p_WB, const Vec4& q_xyzw);
  void health(TimeNs t, HealthState state, const std::string& what);
  void points(const std::vector<ViewPoint>& points);
  void image(ViewImage image);
  void counters(const std::map<std::string, uint64_t>& counters);
  void fused(const FusedPose& pose);
  void fix(const Vec3& p_E, FixGate gate);
  void answer(const std::string& id, const std::string& text);
  void system(const nlohmann::json& load);
  // Of an earlier run. `loaded`: W is its frame only while the pose is in_map.
  void earlier_map(const std::vector<Eigen::Vector3f>& points, bool loaded = false);
  // A message of its own that every page gets: a whole run.
  void lasting(ViewMessage message);
  // Path, keyframes and points so far.
  void forget();

  // ---- the server ----
  std::vector<ViewMessage> all();
  std::vector<ViewMessage> news(TimeNs now);

 private:
  struct Place {
    float x, y, z, confidence, segment;
  };
  struct Keyframe {
    float p[3], q[4];
  };
  struct KnownPoint {
    ViewPoint point;
    bool old = false;  // told before the pose last jumped
  };
  struct PointRow {
    uint32_t id;
    float x, y, z, sigma;
    uint32_t old;
  };
  struct FusedPlace {
    float x, y, z, sigma;
  };
  struct FixPlace {
    float x, y, z, gate;
  };
  // Counted since the last rates.
  struct Rates {
    TimeNs since = 0;
    int poses = 0, frames = 0;
    std::vector<float> imu_to_pose_ms, frame_to_pose_ms;
  };

  void forget_locked();
  void add_keyframe(const Vec3& p_WB, const Vec4& q_xyzw);
  void extend_path(const ViewPose& pose);
  void note_jump(const ViewPose& before, const ViewPose& now);
  void add_event(TimeNs t, HealthState state, const std::string& what);
  ViewMessage earlier_message() const;
  ViewMessage state_message() const;
  ViewMessage frame_message() const;
  nlohmann::json hello() const;
  ViewMessage rates_message(TimeNs now);
  static ViewMessage points_message(const std::vector<PointRow>& rows);
  ViewMessage fused_message(size_t from) const;
  void put_news_of_map(std::vector<ViewMessage>& out);
  nlohmann::json earth_to_world() const;

  std::mutex mutex_;
  nlohmann::json source_ = nlohmann::json::object();
  nlohmann::json source_state_ = {{"type", "source"}, {"state", "waiting"}, {"what", ""}};
  std::optional<ViewPose> pose_;
  std::optional<ViewFrame> frame_;
  bool pose_new_ = false, frame_new_ = false, fused_new_ = false;
  std::vector<Place> path_;
  size_t path_told_ = 0;
  float path_step_m_ = 0.01F;
  std::vector<Keyframe> keyframes_;
  size_t keyframes_told_ = 0;
  std::unordered_map<uint32_t, KnownPoint> points_;
  std::deque<uint32_t> points_order_;
  std::unordered_map<uint32_t, PointRow> points_new_;
  std::vector<Eigen::Vector3f> earlier_map_;
  bool earlier_is_loaded_ = false;
  std::deque<nlohmann::json> events_;
  std::map<std::string, uint64_t> counters_;
  nlohmann::json system_;
  std::optional<FusedPose> fused_;
  std::vector<FusedPlace> fused_path_;
  std::vector<FixPlace> fixes_;
  size_t fused_told_ = 0, fixes_told_ = 0;
  std::optional<ViewPose> fused_pose_;  // of SLAM, when fused_ was told
  std::vector<ViewMessage> lasting_;
  std::vector<ViewMessage> pending_;
  Rates rates_;
  std::optional<ViewMessage> newest_rates_;
};

}  // namespace pirvs::tools
