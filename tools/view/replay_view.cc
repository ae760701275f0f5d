#include "tools/view/replay_view.h"

#include <chrono>

#include "board/linux/text_commands.h"
#include "bsp/api/clock.h"
#include "bsp/replay/sensors.h"
#include "core/base/text.h"
#include "core/math/so3.h"
#include "core/math/trig.h"
#include "modules/tracking/tracker.h"
#include "tools/dataset/input_error.h"
#include "tools/view/page.h"
#include "tools/view/system_load.h"

namespace pirvs::tools {

using nlohmann::json;

namespace {

constexpr TimeNs kPointsPeriod_ns = 200'000'000;
constexpr int kCountersMax = 512;

json camera_json(const Camera& camera) {
  const SE3& T_BC = camera.T_BC;
  return {{"width", camera.width},
          {"height", camera.height},
          {"focal", {camera.fx, camera.fy}},
          {"p", view_numbers(T_BC.p)},
          {"q", view_numbers(quat_xyzw(T_BC.R))}};
}

Vec3 sigmas(const Mat9& cov, int from) {
  return cov.diagonal().segment<3>(from).cwiseMax(0).cwiseSqrt();
}

}  // namespace

ReplayView::ReplayView(View& view, const Recording& recording, std::string files)
    : view_(view), scene_(view.scene()), encoder_(view.scene()), files_(std::move(files)) {
  json cameras = json::array();
  for (int c = 0; c < recording.calibration.cameras; ++c) {
    cameras.push_back(camera_json(recording.calibration.camera[c]));
  }
  scene_.begin({{"kind", "replay"},
                {"name", recording.folder},
                {"duration", view_number(recording.duration_s())},
                {"cameras", cameras},
                {"commands",
                 {"stop", "reset", "pose", "parameter", "map save", "map load", "node set",
                  "node get", "node remove"}}});
}

ReplayView::~ReplayView() { close("the run was cut off"); }

void ReplayView::open(App& app) {
  app_ = &app;
  scene_.source_is("connected", "");
  view_.obeyed_by([this](const std::string& id, const std::string& line) { obey(id, line); });
  thread_ = std::thread([this] { count(); });
}

void ReplayView::close(const std::string& why) {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
  view_.obeyed_by(nullptr);
  scene_.source_is("ended", why);
  const std::lock_guard lock(asked_mutex_);
  for (const auto& [ticket, asked] : asked_) scene_.answer(asked.id, "error the replay has ended");
  asked_.clear();
}

// ---- from core 0 -------------------------------------------------------------------------------

void ReplayView::frame(const FrameReport& report) {
  ViewFrame out;
  out.t = report.t;
  out.health = report.pose.health;
  out.has_pose = report.has_pose;
  out.keyframe = report.keyframe;
  out.at_rest = report.at_rest;
  out.p_WB = report.pose.state.T_WB.p;
  if (report.has_pose) out.q_xyzw = quat_xyzw(report.pose.state.T_WB.R);
  for (int c = 0; c < kCamerasMax; ++c) out.tracks[c] = report.tracks[c];
  out.correspondences = report.correspondences;
  out.accepted = report.accepted;
  out.image_ms = report.image_ms;
  out.matching_ms = report.matching_ms;
  out.tracking_ms = report.tracking_ms;
  out.mapping_ms = report.mapping_ms;
  out.total_ms = report.end_to_end_ms;
  scene_.frame(out);
}

void ReplayView::tracked(TimeNs t, const StereoFrame& images, const Tracker& tracker) {
  if (view_.server().pages() > 0) encoder_.offer(t, images, tracker);
  const TimeNs now = bsp::now();
  if (now < points_t_) return;
  points_t_ = now + kPointsPeriod_ns;
  SeenPoint seen[kCamerasMax * kTracksMax];
  const int count = tracker.seen_points(seen, kCamerasMax * kTracksMax);
  std::vector<ViewPoint> points;
  points.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) {
    // As the device's stream numbers them.
    points.push_back({seen[i].id.generation << 13 | seen[i].id.slot, seen[i].p_W.cast<float>(),
                      static_cast<float>(seen[i].sigma_m)});
  }
  scene_.points(points);
}

void ReplayView::pose(const Pose& pose) {
  ViewPose out;
  out.t = pose.state.t;
  out.host_t = bsp::now() - (bsp::replay_now() - pose.state.t);
  out.t_published = pose.t_published;
  out.t_frame = pose.t_frame;
  out.p_WB = pose.state.T_WB.p;
  out.v_WB = pose.state.v_WB;
  out.w_B = pose.w_B;
  out.q_xyzw = quat_xyzw(pose.state.T_WB.R);
  out.sigma_theta = sigmas(pose.cov, 0);
  out.sigma_p = sigmas(pose.cov, 3);
  out.sigma_v = sigmas(pose.cov, 6);
  out.health = pose.health;
  out.confidence = pose.trust.confidence;
  out.jump_m = pose.trust.jump_m;
  out.resets = pose.trust.resets;
  out.reasons = pose.trust.reasons;
  out.epoch = pose.epoch;
  out.dead_reckoning = pose.dead_reckoning;
  out.in_map = pose.in_map;
  scene_.pose(out);
}

void ReplayView::health(TimeNs t, HealthState state, const char* what) {
  scene_.health(t, state, what);
}

void ReplayView::fused(const FusedPose& pose) {
  has_fused_ = true;
  scene_.fused(pose);
}

// Before the first good fix there is no E.
void ReplayView::fix(const GnssFix& fix, FixGate gate) {
  if (!has_fused_) return;
  constexpr double kDegree = kPi / 180;
  const Geodetic place = {fix.latitude_deg * kDegree, fix.longitude_deg * kDegree, fix.height_m};
  scene_.fix(app_->local_frame().to_local(place), gate);
}

void ReplayView::answer(const Answer& answer) {
  Asked asked;
  {
    const std::lock_guard lock(asked_mutex_);
    const auto at = asked_.find(answer.ticket);
    if (at == asked_.end()) return;
    asked = at->second;
    asked_.erase(at);
  }
  Text<160> line;
  board::put_answer(line, answer);
  scene_.answer(asked.id, line.c_str());
  if (answer.status != Status::kOk) return;
  if (answer.kind == CommandKind::kLoadMap) show_map_later(files_ + "/" + asked.text);
  if (answer.kind == CommandKind::kReset) show_map_later("");
}

// Reading it takes longer than core 0 has.
void ReplayView::show_map_later(const std::string& file) {
  {
    const std::lock_guard lock(mutex_);
    map_ = file;
    map_is_new_ = true;
  }
  wake_.notify_one();
}

// ---- from other threads ------------------------------------------------------------------------

void ReplayView::obey(const std::string& id, const std::string& line) {
  const board::TextRequest request = board::read_request(line);
  Text<256> answer;
  switch (request.kind) {
    case board::RequestKind::kCommand: {
      const std::lock_guard lock(asked_mutex_);  // before its answer can come
      const Result<uint32_t> ticket = app_->command(request.command);
      if (ticket.ok()) {
        asked_[ticket.value()] = {id, request.command.text};
        return;
      }
      board::put_answer(answer, {0, request.command.kind, ticket.status(), SE3{}});
      break;
    }
    case board::RequestKind::kBad:
      board::put_error(answer, request.why);
      break;
    case board::RequestKind::kHelp:
      board::put_help(answer);
      break;
    default:
      board::put_error(answer, "the page shows that");
  }
  scene_.answer(id, answer.c_str());
}

void ReplayView::show_map(const std::string& file) {
  try {
    scene_.earlier_map(file.empty() ? std::vector<Eigen::Vector3f>() : read_points(file), true);
  } catch (const InputError& error) {
    scene_.earlier_map({}, true);  // it was replaced since
  }
}

void ReplayView::count() {
  SystemLoad load;
  (void)load.measure();
  std::unique_lock lock(mutex_);
  auto next = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  for (;;) {
    const bool woken = wake_.wait_until(lock, next, [this] { return stop_ || map_is_new_; });
    if (stop_) return;
    if (woken) {
      map_is_new_ = false;
      show_map(map_);
      continue;
    }
    next += std::chrono::seconds(1);
    NamedValue values[kCountersMax];
    const int count = app_->counters(values, kCountersMax);
    std::map<std::string, uint64_t> counters;
    for (int i = 0; i < count; ++i) counters[values[i].name] += values[i].value;
    scene_.counters(counters);
    scene_.system(load.measure());
  }
}

}  // namespace pirvs::tools
