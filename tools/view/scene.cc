#include "tools/view/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/math/so3.h"
#include "tools/run/verdict.h"

namespace pirvs::tools {

using nlohmann::json;
using Kind = ViewMessage::Kind;

namespace {

constexpr TimeNs kSecond_ns = 1'000'000'000;

// Every other one is left out, ends excepted.
template <class T>
void thin(std::vector<T>& list) {
  size_t kept = 0;
  for (size_t i = 0; i < list.size(); i += 2) list[kept++] = list[i];
  list.resize(kept);
}

template <class T>
ViewMessage rows_message(const char* type, const std::vector<T>& rows, size_t from, bool all) {
  const json header = {{"type", type}, {"all", all}, {"count", rows.size() - from}};
  return view_message(header, rows.data() + from, (rows.size() - from) * sizeof(T));
}

json statistics(std::vector<float> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return view_number(double(values[static_cast<size_t>(share * double(values.size() - 1))]));
  };
  return {{"median", at(0.5)}, {"p99", at(0.99)}, {"max", at(1)}};
}

}  // namespace

// ---- the source --------------------------------------------------------------------------------

void ViewScene::begin(const json& source) {
  const std::lock_guard lock(mutex_);
  source_ = source;
  forget_locked();
  pose_.reset();
  frame_.reset();
  fused_.reset();
  fused_path_.clear();
  fixes_.clear();
  fused_told_ = fixes_told_ = 0;
  events_.clear();
  counters_.clear();
  lasting_.clear();
  pending_.clear();
  pending_.push_back(view_message(hello()));
  if (!earlier_map_.empty()) pending_.push_back(earlier_message());
}

void ViewScene::source_is(const char* state, const std::string& what) {
  const std::lock_guard lock(mutex_);
  const json now = {{"type", "source"}, {"state", state}, {"what", what}};
  if (now == source_state_) return;
  source_state_ = now;
  pending_.push_back(view_message(now));
}

void ViewScene::forget_locked() {
  path_.clear();
  keyframes_.clear();
  points_.clear();
  points_order_.clear();
  points_new_.clear();
  path_told_ = keyframes_told_ = 0;
  path_step_m_ = 0.01F;
}

void ViewScene::forget() {
  const std::lock_guard lock(mutex_);
  forget_locked();
  fused_path_.clear();
  fixes_.clear();
  fused_told_ = fixes_told_ = 0;
  pending_.push_back(view_message({{"type", "forget"}}));
}

// Points that were told before may have another place by now. A device does not tell how far.
void ViewScene::note_jump(const ViewPose& before, const ViewPose& now) {
  if (before.resets != now.resets) {
    for (auto& [id, known] : points_) known.old = true;
    const Vec3 moved = before.v_WB * to_seconds(now.t - before.t);
    const double far_m =
        now.jump_m > 0 ? double(now.jump_m) : (now.p_WB - before.p_WB - moved).norm();
    pending_.push_back(view_message({{"type", "jump"},
                                     {"t", view_time(now.t)},
                                     {"resets", now.resets},
                                     {"m", view_number(far_m)}}));
    char text[80];
    std::snprintf(text, sizeof text, "the pose jumped by %.3f m: reset %u", far_m,
                  static_cast<unsigned>(now.resets));
    add_event(now.t, now.health, text);
  }
  if (before.epoch != now.epoch) {
    add_event(now.t, now.health,
              "epoch " + std::to_string(before.epoch) + " to " + std::to_string(now.epoch));
  }
  if (before.in_map != now.in_map) {
    add_event(now.t, now.health,
              now.in_map ? "localised in the loaded map" : "no longer in the loaded map");
  }
}

void ViewScene::extend_path(const ViewPose& pose) {
  const Eigen::Vector3f p = pose.p_WB.cast<float>();
  const auto segment = static_cast<float>(pose.resets);
  if (!path_.empty()) {
    const Place& last = path_.back();
    const bool near = (p - Eigen::Vector3f(last.x, last.y, last.z)).norm() < path_step_m_;
    if (near && last.segment == segment) return;
  }
  if (path_.size() >= kPathMax) {
    thin(path_);
    path_step_m_ *= 2;
    path_told_ = 0;
  }
  path_.push_back({p.x(), p.y(), p.z(), pose.confidence, segment});
}

void ViewScene::pose(const ViewPose& pose) {
  const std::lock_guard lock(mutex_);
  if (pose_.has_value()) note_jump(*pose_, pose);
  const bool frame_is_new = !pose_.has_value() || pose_->t_frame != pose.t_frame;
  pose_ = pose;
  pose_new_ = true;
  extend_path(pose);
  ++rates_.poses;
  if (frame_is_new) ++rates_.frames;
  if (pose.t_published == 0) return;
  const auto since = [&](TimeNs t) { return static_cast<float>(pose.t_published - t) * 1e-6F; };
  rates_.imu_to_pose_ms.push_back(since(pose.t));
  if (frame_is_new) rates_.frame_to_pose_ms.push_back(since(pose.t_frame));
}

void ViewScene::frame(const ViewFrame& frame) {
  const std::lock_guard lock(mutex_);
  frame_ = frame;
  frame_new_ = true;
  if (frame.keyframe && frame.has_pose) add_keyframe(frame.p_WB, frame.q_xyzw);
}

void ViewScene::keyframe(const Vec3& p_WB, const Vec4& q_xyzw) {
  const std::lock_guard lock(mutex_);
  add_keyframe(p_WB, q_xyzw);
}

void ViewScene::add_keyframe(const Vec3& p_WB, const Vec4& q_xyzw) {
  if (keyframes_.size() >= kPathMax) {
    thin(keyframes_);
    keyframes_told_ = 0;
  }
  Keyframe keyframe;
  for (int i = 0; i < 3; ++i) keyframe.p[i] = static_cast<float>(p_WB[i]);
  for (int i = 0; i < 4; ++i) keyframe.q[i] = static_cast<float>(q_xyzw[i]);
  keyframes_.push_back(keyframe);
}

void ViewScene::health(TimeNs t, HealthState state, const std::string& what) {
  const std::lock_guard lock(mutex_);
  add_event(t, state, what);
}

void ViewScene::add_event(TimeNs t, HealthState state, const std::string& what) {
  events_.push_back(
      {{"type", "event"}, {"t", view_time(t)}, {"health", name(state)}, {"what", what}});
  if (events_.size() > kEventsMax) events_.pop_front();
  pending_.push_back(view_message(events_.back()));
}

void ViewScene::points(const std::vector<ViewPoint>& points) {
  const std::lock_guard lock(mutex_);
  for (const ViewPoint& point : points) {
    const auto [at, is_new] = points_.insert_or_assign(point.id, KnownPoint{point, false});
    if (is_new) points_order_.push_back(point.id);
    points_new_[point.id] = {point.id,      point.p_W.x(), point.p_W.y(),
                             point.p_W.z(), point.sigma_m, 0};
  }
  while (points_.size() > kPointsMax) {
    points_.erase(points_order_.front());
    points_order_.pop_front();
  }
}

void ViewScene::image(ViewImage image) {
  const json header = {{"type", "image"},          {"t", view_time(image.t)},
                       {"camera", image.camera},   {"width", image.width},
                       {"height", image.height},   {"tracks", image.tracks.size()},
                       {"jpeg", image.jpeg.size()}};
  std::string array(reinterpret_cast<const char*>(image.tracks.data()),
                    image.tracks.size() * sizeof(ViewTrack));
  array += image.jpeg;
  ViewMessage message = view_message(header, array.data(), array.size(),
                                     image.camera == 0 ? Kind::kImageLeft : Kind::kImageRight);
  const std::lock_guard lock(mutex_);
  pending_.push_back(std::move(message));
}

void ViewScene::counters(const std::map<std::string, uint64_t>& counters) {
  const std::lock_guard lock(mutex_);
  counters_ = counters;
  pending_.push_back(view_message({{"type", "counters"}, {"values", counters_}}));
}

void ViewScene::fused(const FusedPose& pose) {
  const std::lock_guard lock(mutex_);
  fused_ = pose;
  fused_pose_ = pose_;
  fused_new_ = true;
  const Eigen::Vector3f p = pose.T_EB.p.cast<float>();
  if (!fused_path_.empty()) {
    const FusedPlace& last = fused_path_.back();
    if ((p - Eigen::Vector3f(last.x, last.y, last.z)).norm() < 0.05F) return;
  }
  if (fused_path_.size() >= kPathMax) {
    thin(fused_path_);
    fused_told_ = 0;
  }
  const double variance_m2 = (pose.cov(3, 3) + pose.cov(4, 4)) / 2;
  fused_path_.push_back({p.x(), p.y(), p.z(), static_cast<float>(std::sqrt(variance_m2))});
}

void ViewScene::fix(const Vec3& p_E, FixGate gate) {
  const std::lock_guard lock(mutex_);
  if (!p_E.allFinite()) return;
  if (fixes_.size() >= kPathMax) {
    thin(fixes_);
    fixes_told_ = 0;
  }
  const Eigen::Vector3f p = p_E.cast<float>();
  fixes_.push_back({p.x(), p.y(), p.z(), static_cast<float>(gate)});
}

void ViewScene::answer(const std::string& id, const std::string& text) {
  const std::lock_guard lock(mutex_);
  pending_.push_back(view_message({{"type", "answer"}, {"id", id}, {"text", text}}));
}

void ViewScene::system(const json& load) {
  const std::lock_guard lock(mutex_);
  system_ = load;
  system_["type"] = "system";
  pending_.push_back(view_message(system_));
}

void ViewScene::earlier_map(const std::vector<Eigen::Vector3f>& points, bool loaded) {
  const std::lock_guard lock(mutex_);
  earlier_map_ = points;
  earlier_is_loaded_ = loaded;
  pending_.push_back(earlier_message());
}

void ViewScene::lasting(ViewMessage message) {
  const std::lock_guard lock(mutex_);
  lasting_.push_back(message);
  pending_.push_back(std::move(message));
}

// ---- the server --------------------------------------------------------------------------------

json ViewScene::hello() const {
  constexpr int kSchema = 1;
  json gates = json::array(), uses = {"new", "waiting", "used", "rejected"};
  for (int i = 0; i < static_cast<int>(FixGate::kCount); ++i) {
    gates.push_back(name(static_cast<FixGate>(i)));
  }
  return {{"type", "hello"},
          {"schema", kSchema},
          {"source", source_},
          {"fix_gates", gates},
          {"track_uses", uses}};
}

ViewMessage ViewScene::earlier_message() const {
  const json header = {{"type", "earlier_map"},
                       {"all", true},
                       {"count", earlier_map_.size()},
                       {"loaded", earlier_is_loaded_}};
  return view_message(header, earlier_map_.data(), earlier_map_.size() * sizeof earlier_map_[0]);
}

ViewMessage ViewScene::state_message() const {
  const ViewPose& pose = *pose_;
  json reasons = json::array();
  for (int i = 0; i < static_cast<int>(Reason::kCount); ++i) {
    const auto reason = static_cast<Reason>(i);
    if ((pose.reasons & bit(reason)) != 0) reasons.push_back(name(reason));
  }
  const json out = {{"type", "state"},
                    {"t", view_time(pose.t)},
                    {"host_t", view_time(pose.host_t)},
                    {"frame_age", view_time(pose.t - pose.t_frame)},
                    {"p", view_numbers(pose.p_WB)},
                    {"q", view_numbers(pose.q_xyzw)},
                    {"v", view_numbers(pose.v_WB)},
                    {"w", view_numbers(pose.w_B)},
                    {"sigma_p", view_numbers(pose.sigma_p)},
                    {"sigma_theta", view_numbers(pose.sigma_theta)},
                    {"sigma_v", view_numbers(pose.sigma_v)},
                    {"health", name(pose.health)},
                    {"confidence", view_number(double(pose.confidence))},
                    {"reasons", reasons},
                    {"resets", pose.resets},
                    {"epoch", pose.epoch},
                    {"dead_reckoning", pose.dead_reckoning},
                    {"in_map", pose.in_map}};
  return view_message(out, Kind::kState);
}

ViewMessage ViewScene::frame_message() const {
  const ViewFrame& frame = *frame_;
  const auto ms = [](float value) { return view_number(double(value)); };
  const json out = {{"type", "frame"},
                    {"t", view_time(frame.t)},
                    {"health", name(frame.health)},
                    {"tracks", {frame.tracks[0], frame.tracks[1]}},
                    {"correspondences", frame.correspondences},
                    {"accepted", frame.accepted},
                    {"at_rest", frame.at_rest},
                    {"ms",
                     {{"image", ms(frame.image_ms)},
                      {"matching", ms(frame.matching_ms)},
                      {"tracking", ms(frame.tracking_ms)},
                      {"mapping", ms(frame.mapping_ms)},
                      {"total", ms(frame.total_ms)}}}};
  return view_message(out, Kind::kFrame);
}

ViewMessage ViewScene::rates_message(TimeNs now) {
  const double seconds = to_seconds(now - rates_.since);
  const json out = {{"type", "rates"},
                    {"poses_hz", view_number(rates_.poses / seconds)},
                    {"frames_hz", view_number(rates_.frames / seconds)},
                    {"imu_to_pose_ms", statistics(rates_.imu_to_pose_ms)},
                    {"frame_to_pose_ms", statistics(rates_.frame_to_pose_ms)}};
  rates_ = {};
  rates_.since = now;
  return view_message(out);
}

ViewMessage ViewScene::points_message(const std::vector<PointRow>& rows) {
  return rows_message("points", rows, 0, false);
}

// Where E stands in W: both have the body, at nearly the same time. null: not known.
json ViewScene::earth_to_world() const {
  if (!fused_.has_value() || !fused_pose_.has_value() || !fused_->has_heading) return nullptr;
  const Mat3 R_WE = rotation_from_quat_xyzw(fused_pose_->q_xyzw) * fused_->T_EB.R.transpose();
  const Vec3 p_WE = fused_pose_->p_WB - R_WE * fused_->T_EB.p;
  return {{"p", view_numbers(p_WE)}, {"q", view_numbers(quat_xyzw(R_WE))}};
}

ViewMessage ViewScene::fused_message(size_t from) const {
  const FusedPose& newest = *fused_;
  constexpr double kDegree = 3.14159265358979323846 / 180;
  const double variance_m2 = (newest.cov(3, 3) + newest.cov(4, 4)) / 2;
  const json header = {{"type", "fused"},
                       {"all", from == 0},
                       {"count", fused_path_.size() - from},
                       {"health", name(newest.health)},
                       {"latitude", newest.place.latitude_rad / kDegree},
                       {"longitude", newest.place.longitude_rad / kDegree},
                       {"height", view_number(newest.place.height_m)},
                       {"sigma", view_number(std::sqrt(variance_m2))},
                       {"confidence", view_number(double(newest.confidence))},
                       {"T_WE", earth_to_world()}};
  return view_message(header, fused_path_.data() + from,
                      (fused_path_.size() - from) * sizeof(FusedPlace));
}

// What has grown since it was last told.
void ViewScene::put_news_of_map(std::vector<ViewMessage>& out) {
  if (path_told_ < path_.size()) {
    out.push_back(rows_message("path", path_, path_told_, path_told_ == 0));
    path_told_ = path_.size();
  }
  if (keyframes_told_ < keyframes_.size()) {
    out.push_back(rows_message("keyframes", keyframes_, keyframes_told_, keyframes_told_ == 0));
    keyframes_told_ = keyframes_.size();
  }
  if (!points_new_.empty()) {
    std::vector<PointRow> rows;
    rows.reserve(points_new_.size());
    for (const auto& [id, row] : points_new_) rows.push_back(row);
    points_new_.clear();
    out.push_back(points_message(rows));
  }
  if (fused_new_) {
    out.push_back(fused_message(fused_told_));
    fused_told_ = fused_path_.size();
    fused_new_ = false;
  }
  if (fixes_told_ < fixes_.size()) {
    out.push_back(rows_message("fixes", fixes_, fixes_told_, fixes_told_ == 0));
    fixes_told_ = fixes_.size();
  }
}

std::vector<ViewMessage> ViewScene::news(TimeNs now) {
  const std::lock_guard lock(mutex_);
  std::vector<ViewMessage> out = std::move(pending_);
  pending_.clear();
  put_news_of_map(out);
  if (frame_new_) out.push_back(frame_message());
  if (pose_new_) out.push_back(state_message());
  pose_new_ = frame_new_ = false;
  if (rates_.since == 0) rates_.since = now;
  if (now >= rates_.since + kSecond_ns) {
    newest_rates_ = rates_message(now);
    out.push_back(*newest_rates_);
  }
  return out;
}

std::vector<ViewMessage> ViewScene::all() {
  const std::lock_guard lock(mutex_);
  std::vector<ViewMessage> out = {view_message(hello()), view_message(source_state_)};
  out.insert(out.end(), lasting_.begin(), lasting_.end());
  if (!earlier_map_.empty()) out.push_back(earlier_message());
  for (const json& event : events_) out.push_back(view_message(event));
  if (!path_.empty()) out.push_back(rows_message("path", path_, 0, true));
  if (!keyframes_.empty()) out.push_back(rows_message("keyframes", keyframes_, 0, true));
  std::vector<PointRow> rows;
  rows.reserve(points_.size());
  for (const auto& [id, known] : points_) {
    const ViewPoint& point = known.point;
    rows.push_back({id, point.p_W.x(), point.p_W.y(), point.p_W.z(), point.sigma_m, known.old});
  }
  if (!rows.empty()) out.push_back(points_message(rows));
  if (fused_.has_value()) out.push_back(fused_message(0));
  if (!fixes_.empty()) out.push_back(rows_message("fixes", fixes_, 0, true));
  if (!counters_.empty())
    out.push_back(view_message({{"type", "counters"}, {"values", counters_}}));
  if (!system_.is_null()) out.push_back(view_message(system_));
  if (newest_rates_.has_value()) out.push_back(*newest_rates_);
  if (frame_.has_value()) out.push_back(frame_message());
  if (pose_.has_value()) out.push_back(state_message());
  return out;
}

}  // namespace pirvs::tools
