#include "modules/app/estimator.h"

#include <algorithm>
#include <cmath>

#include "bsp/api/clock.h"
#include "core/math/trig.h"
#include "core/trace/trace.h"

namespace pirvs {
namespace {

// What the health log says of a frame; nullptr: nothing.
const char* event_of(const FrameResult& result) {
  if (result.started && result.joined) return "started, recognised the old map";
  if (result.started) return result.started_at_rest ? "started at rest" : "started in motion";
  if (result.joined) return "recognised the old map";
  if (result.closed) return "closed a loop";
  if (result.recognised) return "recognised the place";
  return result.health_changed ? "health changed" : nullptr;
}

// Smaller errors are not told.
constexpr double kTold_s = 4e-3, kTold_rad = 0.7 * kPi / 180, kTold_scale = 0.01,
                 kBent_rad = 0.25 * kPi / 180;

bool is_off(double by, double sigma, double told) {
  constexpr double kSigmas = 10;  // observations are not independent
  return std::fabs(by) > told && std::fabs(by) > kSigmas * sigma;
}

float to_ms(int64_t ns) { return static_cast<float>(ns) * 1e-6f; }

}  // namespace

void Estimator::configure(const Calibration& calibration, const AppParams& params,
                          const AppSinks& sinks) {
  calibration_ = calibration;
  params_ = params;
  sinks_ = sinks;
  for (int c = 0; c < kCamerasMax; ++c) {
    frontend_[c].configure(calibration.camera[c], params.frontend);
  }
  configure_tracking();
}

void Estimator::configure_tracking() {
  const ImuNoise noise = scaled(calibration_.imu, params_.imu);
  tracker_.configure(calibration_.camera, calibration_.cameras, noise, params_.tracking, frontend_,
                     &keyframe_ring_, &map_mailbox_);
  tracker_.configure_wheels(calibration_.wheels);
  mapper_.configure(calibration_.camera, noise, params_.mapping, &keyframe_ring_, &map_mailbox_);
  mapper_.on_keyframe_removed(sinks_.keyframe, sinks_.context);
}

// A consumer that counts resets sees one more, not a count that begins again.
void Estimator::reset(TimeNs t, const char* why) {
  const MappingHold hold(*this);
  rebuild(t, why);
}

void Estimator::rebuild(TimeNs t, const char* why) {
  resets_before_ += tracker_.trust().resets + 1;
  tracker_.forget();
  mapper_.forget();
  (void)map_mailbox_.take();
  map_gate_.restart();
  configure_tracking();
  for (Frontend& frontend : frontend_) frontend.reset();
  tell_health(t, why);
}

void Estimator::retune(const AppParams& params) {
  const MappingHold hold(*this);
  params_ = params;
  for (Frontend& frontend : frontend_) frontend.retune(params.frontend);
  configure_tracking();
}

Status Estimator::set_pose(TimeNs t, const Vec3& p_WB, double yaw_rad, double sigma_m) {
  if (sigma_m > 0 && tracker_.in_map()) return Status::kStale;
  const SE3 now = tracker_.place();
  const Vec2 heading = now.R.col(0).head<2>();
  constexpr double kVertical = 0.05;  // sine of the angle to the vertical
  if (heading.norm() < kVertical) return Status::kStale;
  const Vec2 from = heading.normalized();
  const double c = cosine(yaw_rad), s = sine(yaw_rad);
  SE3 T;
  T.R << c * from.x() + s * from.y(), c * from.y() - s * from.x(), 0,  //
      s * from.x() - c * from.y(), c * from.x() + s * from.y(), 0,     //
      0, 0, 1;
  T.p = p_WB - T.R * now.p;
  const MappingHold hold(*this);
  if (sigma_m > 0 && tracker_.has_loaded_map()) {
    tracker_.continue_at(t, T * now, sigma_m);
    for (Frontend& frontend : frontend_) frontend.reset();
    tell_health(t, "pose hint in the loaded map");
    return Status::kOk;
  }
  mapper_.move_world(T);
  tracker_.move_world(T);
  tell_health(t, "pose set by command");
  return Status::kOk;
}

Status Estimator::load_map(TimeNs t, const MapSource& source) {
  const MappingHold hold(*this);
  if (tracker_.counters().frames > 0) rebuild(t, "gave up what ran for a saved map");
  PIRVS_TRY(mapper_.load(source));
  uint32_t sequence = 0;
  uint16_t epoch = 0;
  for (size_t slot = 0; slot < mapper_.map().keyframes.capacity(); ++slot) {
    const Keyframe* keyframe = mapper_.map().keyframes.at(slot);
    if (keyframe == nullptr) continue;
    sequence = std::max(sequence, keyframe->sequence);
    epoch = std::max(epoch, keyframe->epoch);
  }
  tracker_.continue_map(sequence, epoch);
  return Status::kOk;
}

Status Estimator::set_node(const char* name, const SE3& T_WN) {
  if (!tracker_.running()) return Status::kStale;
  return pirvs::set_node(mapper_.map(), name, T_WN, tracker_.epoch());
}

FusedState Estimator::fused() const {
  FusedState out = {tracker_.state(), tracker_.cov(),    tracker_.health(),  tracker_.trust(),
                    tracker_.epoch(), tracker_.in_map(), tracker_.running(), tracker_.at_rest()};
  out.trust.resets += resets_before_;
  return out;
}

void Estimator::tell_health(TimeNs t, const char* what) {
  if (sinks_.health != nullptr) sinks_.health(sinks_.context, t, tracker_.health(), what);
}

void Estimator::interrupt(TimeNs t, const char* why) {
  tracker_.interrupt();
  for (Frontend& frontend : frontend_) frontend.reset();
  tell_health(t, why);
}

void Estimator::imu(const ImuSample& sample, bool stamps_in_doubt) {
  const TimeNs begin = bsp::cpu_time();
  {
    PIRVS_TRACE("imu");
    tracker_.doubt_stamps(stamps_in_doubt);
    tracker_.add_imu(sample);
  }
  tracking_ns_ += bsp::cpu_time() - begin;
}

void Estimator::begin(const DoorFrame& frame) {
  flush_report();
  frame_ = frame;
  const auto kept = static_cast<uint8_t>(frame.images.present & ~tracker_.left_out(frame.t));
  if (kept != 0) frame_.images.present = kept;
  for (int c = 0; c < kCamerasMax; ++c) {
    if ((frame_.images.present >> c & 1) == 0) frontend_[c].reset();
  }
  map_gate_.frame(tracker_.sent());
  stage_.store(Stage::kMap, std::memory_order_relaxed);
}

Step Estimator::wait_for_map() {
  if (stage_.load(std::memory_order_relaxed) != Stage::kMap) return Step::kIdle;
  if (!map_gate_.ready(mapper_.finished())) return Step::kIdle;
  PIRVS_TRACE("door.frame");
  const TimeNs begin = bsp::cpu_time();
  gravity_B_ = tracker_.prepare(mapper_.finished());
  tracking_ns_ += bsp::cpu_time() - begin;
  frontends_left_.store(kCamerasMax);
  stage_.store(Stage::kFrontend, std::memory_order_release);
  for (auto& todo : frontend_todo_) todo.store(true, std::memory_order_release);
  return Step::kAgain;
}

Step Estimator::frontend_step(int c) {
  if (!frontend_todo_[c].load(std::memory_order_acquire)) return Step::kIdle;
  PIRVS_TRACE("frontend");
  const TimeNs begin = bsp::cpu_time();
  if ((frame_.images.present >> c & 1) != 0) {
    const Vec3 gravity_C = calibration_.camera[c].T_BC.R.transpose() * gravity_B_;
    (void)frontend_[c].process(frame_.images.image[c], frame_.t, gravity_C);
  }
  frontend_ns_[c].store(bsp::cpu_time() - begin);
  frontend_todo_[c].store(false, std::memory_order_relaxed);
  if (frontends_left_.fetch_sub(1) == 1) stage_.store(Stage::kTracking, std::memory_order_release);
  return Step::kAgain;
}

Step Estimator::tracking_step() {
  if (stage_.load(std::memory_order_acquire) != Stage::kTracking) return Step::kIdle;
  PIRVS_TRACE("tracking");
  const TimeNs begin = bsp::cpu_time();
  {
    PIRVS_TRACE("matching");
    tracker_.match();
  }
  const TimeNs matched = bsp::cpu_time();
  const FrameResult result = tracker_.frame(frame_.t, frame_.images.present);
  tracking_ns_ += bsp::cpu_time() - matched;
  report(result, matched - begin);
  const char* what = event_of(result);
  if (what != nullptr) tell_health(frame_.t, what);
  tell_calibration();
  stage_.store(Stage::kIdle, std::memory_order_release);
  return Step::kAgain;
}

// What the calibration says cannot be, by far; once each. The state takes up a part of a large
// error, so that what is told is rather too small.
void Estimator::tell_calibration() {
  const SelfCalibration::Estimate now = tracker_.self_calibration();
  auto& [time, turn, scale, pair] = calibration_news_;
  const bool corrected = params_.tracking.tracker.estimate_time > 0.5f;
  if (!corrected && time.size() == 0 && is_off(now.time_s, now.time_sigma_s, kTold_s)) {
    time.put("images are about ")
        .fixed(1e3 * std::fabs(now.time_s), 1)
        .put(now.time_s < 0 ? " ms older" : " ms newer")
        .put(" than their stamps say on the IMU's clock: timeshift_cam_imu, or ")
        .put("--estimate time");
    tell_health(frame_.t, time.c_str());
  }
  if (pair.size() == 0 && tracker_.counters().cameras_left_out > 0) {
    pair.put("the cameras disagree: ")
        .put(tracker_.left_out(frame_.t) == kRightAlone ? "cam1" : "cam0")
        .put(" is left out for a while; ");
    const double turn_rad = tracker_.stereo().turn().turn_B().norm();
    if (turn_rad > kBent_rad) {
      pair.put("they are turned against each other by about ")
          .fixed(turn_rad * 180 / kPi, 1)
          .put(" degrees, other than T_BS says");
    } else {
      pair.put("trigger, exposure, or its T_BS?");
    }
    tell_health(frame_.t, pair.c_str());
  }
  const double turn_rad = now.turn_B.norm(), sigma_rad = now.turn_sigma_B.maxCoeff();
  if (turn.size() == 0 && is_off(turn_rad, sigma_rad, kTold_rad)) {
    turn.put("the cameras are turned by about ")
        .fixed(turn_rad * 180 / kPi, 1)
        .put(" degrees against the IMU, other than T_BS says");
    tell_health(frame_.t, turn.c_str());
  }
  const bool enlarged = params_.tracking.wheels.estimate_scale > 0.5f;
  if (!enlarged && scale.size() == 0 && is_off(now.scale, now.scale_sigma, kTold_scale)) {
    scale.put("the wheels are about ")
        .fixed(100 * std::fabs(now.scale), 1)
        .put(now.scale < 0 ? " % smaller" : " % larger")
        .put(" than their calibration says: radius, or --set wheels.estimate_scale=1");
    tell_health(frame_.t, scale.c_str());
  }
}

void Estimator::report(const FrameResult& result, TimeNs matching_ns) {
  report_ = FrameReport{};
  report_.t = frame_.t;
  report_.has_pose = result.has_pose;
  report_.pose = fused();
  report_.image_ms = to_ms(frontend_ns_[0] + frontend_ns_[1]);
  report_.matching_ms = to_ms(matching_ns);
  report_.tracking_ms = to_ms(tracking_ns_);
  for (int c = 0; c < kCamerasMax; ++c) {
    report_.tracks[c] = static_cast<int>(frontend_[c].tracks().size());
  }
  report_.correspondences = result.correspondences;
  report_.accepted = result.accepted;
  report_.keyframe = result.keyframe;
  report_.at_rest = result.at_rest;
  report_pending_ = true;
  tracking_ns_ = 0;
}

bool Estimator::mapping_done() const {
  return mapper_.finished() >= std::min(tracker_.sent(), map_gate_.limit());
}

Step Estimator::mapping_step() {
  mapping_inside_.store(true);
  const Step step = mapping_held_.load() ? Step::kIdle : adjust_map();
  mapping_inside_.store(false);
  return step;
}

Step Estimator::adjust_map() {
  if (!mapper_.busy() || mapper_.finished() >= map_gate_.limit()) return Step::kIdle;
  PIRVS_TRACE("mapping");
  const TimeNs begin = bsp::cpu_time();
  mapper_.step();
  mapping_ns_ += bsp::cpu_time() - begin;
  return Step::kAgain;
}

// A frame is reported when the next one begins, so that mapping's share of the time is known.
void Estimator::flush_report() {
  if (!report_pending_) return;
  report_pending_ = false;
  report_.mapping_ms = to_ms(mapping_ns_.exchange(0));
  report_.end_to_end_ms =
      report_.image_ms + report_.matching_ms + report_.tracking_ms + report_.mapping_ms;
  if (sinks_.frame != nullptr) sinks_.frame(sinks_.context, report_);
}

int Estimator::pools(NamedValue* out, int max) {
  const NamedValue table[] = {
      {"frontend", sizeof(frontend_)},       {"tracker", sizeof(tracker_)},
      {"mapper", sizeof(mapper_)},           {"keyframe_ring", sizeof(keyframe_ring_)},
      {"map_mailbox", sizeof(map_mailbox_)},
  };
  int count = 0;
  for (const NamedValue& row : table) {
    if (count < max) out[count++] = row;
  }
  return count;
}

int Estimator::counters(NamedValue* out, int max) const {
  int count = 0;
  const auto add = [&](const char* name, uint64_t value) {
    if (count < max) out[count++] = {name, value};
  };
  CounterArray<TrackLoss> lost_tracks;
  for (const Frontend& frontend : frontend_) lost_tracks += frontend.losses();
  for_each_counter(lost_tracks, add);
  for_each_counter(tracker_.stereo().losses(), add);
  for_each_counter(tracker_.counters().gates, add);
  for_each_counter(tracker_.counters(), kTrackingCounters, add);
  for_each_counter(mapper_.counters(), kMappingCounters, add);
  return count;
}

}  // namespace pirvs
