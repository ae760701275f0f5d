#include "board/library/slam.h"

#include <time.h>

#include <cstring>

#include "board/host/board.h"
#include "board/library/fed_sensors.h"
#include "bsp/api/clock.h"
#include "bsp/api/cores.h"
#include "bsp/api/events.h"
#include "bsp/linux/storage.h"
#include "bsp/linux/text_file.h"
#include "modules/app/replay_pace.h"
#include "modules/calibration/calibration_check.h"
#include "modules/calibration/calibration_text.h"
#include "modules/tracking/tracker.h"

namespace pirvs::board {
namespace {

constexpr TimeNs kAnswer_ns = 10'000'000'000;

App app;
char calibration_text[kCalibrationTextMax];
thread_local char reason[256];
thread_local bool in_callback = false;

// The enums of pirvs.h have the values of the stack's own.
static_assert(PIRVS_INITIALIZING == static_cast<int>(HealthState::kInitializing) &&
              PIRVS_TRACKING == static_cast<int>(HealthState::kTracking) &&
              PIRVS_DEGRADED == static_cast<int>(HealthState::kDegraded) &&
              PIRVS_LOST == static_cast<int>(HealthState::kLost));
static_assert(PIRVS_BLIND == bit(Reason::kBlind) && PIRVS_REJECTED == bit(Reason::kRejected) &&
              PIRVS_JUMPS == bit(Reason::kJumps) && PIRVS_ACCEL_BIAS == bit(Reason::kAccelBias) &&
              PIRVS_GYRO_BIAS == bit(Reason::kGyroBias) && PIRVS_SPEED == bit(Reason::kSpeed) &&
              PIRVS_STAMPS == bit(Reason::kStamps) && PIRVS_DENIED == bit(Reason::kDenied) &&
              PIRVS_PLATFORM == bit(Reason::kPlatform) && PIRVS_CAMERAS == bit(Reason::kCameras) &&
              PIRVS_TURN == bit(Reason::kTurn) && static_cast<int>(Reason::kCount) == 11);

void copy(const Vec3& from, double* to) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

void fill(pirvs_pose& out, const Pose& pose, uint32_t resets) {
  out = pirvs_pose{};
  out.size = sizeof out;
  out.health = static_cast<uint32_t>(pose.health);
  out.t_ns = pose.state.t;
  out.t_frame_ns = pose.t_frame;
  copy(pose.state.T_WB.p, out.p_m);
  const Vec4 q = quat_xyzw(pose.state.T_WB.R);
  for (int i = 0; i < 4; ++i) out.q_xyzw[i] = q[i];
  copy(pose.state.v_WB, out.v_m_s);
  copy(pose.w_B, out.w_rad_s);
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) out.cov[9 * row + column] = pose.cov(row, column);
  }
  out.confidence = pose.trust.confidence;
  out.reasons = pose.trust.reasons;
  out.resets = resets;
  out.jump_m = pose.trust.jump_m;
  out.jump_rad = pose.trust.jump_rad;
  out.epoch = pose.epoch;
  out.in_map = pose.in_map ? 1 : 0;
  out.dead_reckoning = pose.dead_reckoning ? 1 : 0;
}

pirvs_status read_calibration_file(const char* path, Calibration& out) {
  std::string_view text;
  const char* const unread =
      bsp::read_text_file(path, calibration_text, sizeof calibration_text, text);
  if (unread != nullptr) return refuse(PIRVS_NOT_FOUND, unread, path);
  Text<sizeof(reason)> line;
  if (const ConfigFault fault = read_calibration(text, out)) {
    put_fault(line, path, fault);
    return refuse(PIRVS_BAD_DATA, line.c_str());
  }
  if (const CalibrationFault fault = find_fault(out)) {
    line.put(fault.where).put(": ").put(fault.what).put(": ").put(fault.what_to_do);
    return refuse(PIRVS_BAD_DATA, line.c_str(), path);
  }
  return PIRVS_OK;
}

}  // namespace

pirvs_status refuse(pirvs_status status, const char* what, const char* where) {
  TextWriter line(reason, sizeof reason);
  if (where != nullptr) line.put(where).put(": ");
  line.put(what);
  return status;
}

const char* why() { return reason; }

// ---- life --------------------------------------------------------------------------------------

AppSinks Slam::sinks() {
  AppSinks out;
  out.context = this;
  out.tracked = [](void* to, TimeNs t, const StereoFrame&, const Tracker& tracker) {
    static_cast<Slam*>(to)->on_tracked(t, tracker);
  };
  out.health = [](void* to, TimeNs t, HealthState state, const char* what) {
    static_cast<Slam*>(to)->on_news(t, state, what);
  };
  out.imu = [](void* to, const ImuSample& sample) { static_cast<Slam*>(to)->on_imu(sample); };
  out.answer = [](void* to, const Answer& answer) { static_cast<Slam*>(to)->on_answer(answer); };
  return out;
}

pirvs_status Slam::create(const pirvs_config& config) {
  config_ = config;
  if (config_.cores == 0) config_.cores = kCores;
  const pirvs_status status = read_calibration_file(config.calibration, calibration_);
  if (status != PIRVS_OK) return status;
  if (config.mono != 0) calibration_.cameras = 1;
  const Camera& camera = calibration_.camera[0];
  if (camera.width * camera.height > kImagePixelsMax || camera.width > kImageSideMax ||
      camera.height > kImageSideMax) {
    return refuse(PIRVS_BAD_DATA, "images larger than 1280 x 1024", config.calibration);
  }
  bsp::set_storage_directory(config.folder != nullptr ? config.folder : ".");
  return PIRVS_OK;
}

pirvs_status Slam::start() {
  if (life_ != Life::kCreated) return refuse(PIRVS_REFUSED, "it was started already");
  const Camera& camera = calibration_.camera[0];
  open_fed_sensors(camera.width, camera.height, !stepped());
  app.configure(calibration_, params_, sinks());
  taken_ = app.poses().attach().value();
  if (config_.on_pose != nullptr) given_ = app.poses().attach().value();
  if (config_.monotonic != 0) app.set_clock(bsp::now);
  if (stepped()) {
    app.pace(lockstep_may_go_on);
    if (app.start(kPlans[0], Drive::kLockstep) != Status::kOk) {
      life_ = Life::kFailed;
      return refuse(PIRVS_IO, "the stack could not be started");
    }
    life_ = Life::kRuns;
    return PIRVS_OK;
  }
  life_ = Life::kRuns;
  const auto entry = [](void* slam) -> void* {
    static_cast<Slam*>(slam)->run();
    return nullptr;
  };
  started_ = false;
  const bool has_thread = pthread_create(&thread_, nullptr, entry, this) == 0;
  while (has_thread && !started_) bsp::relax();
  if (has_thread && life_ == Life::kRuns) return PIRVS_OK;
  if (has_thread) pthread_join(thread_, nullptr);
  life_ = Life::kFailed;
  return refuse(PIRVS_IO, "a thread could not be started");
}

// The thread that is core 0.
void Slam::run() {
  const bool good = app.start(kPlans[config_.cores - 1], Drive::kTimed) == Status::kOk;
  if (!good) life_ = Life::kFailed;
  started_ = true;
  while (good && app.poll() != Status::kStale) give_out();
  ended_ = app.finish();
  give_out();
}

void Slam::drain() {
  while (app.poll() == Status::kOk) give_out();
}

pirvs_status Slam::stop() {
  if (in_callback) return refuse(PIRVS_REFUSED, "not from a callback");
  if (life_ != Life::kRuns) return refuse(PIRVS_REFUSED, "it does not run");
  end_fed_sensors();
  if (stepped()) {
    drain();
    ended_ = app.finish();
    give_out();
  } else {
    bsp::wake(0);
    pthread_join(thread_, nullptr);
  }
  life_ = Life::kStopped;
  return ended_ == Status::kOk ? PIRVS_OK : refuse(PIRVS_BAD_DATA, "tracking found no start");
}

// ---- in ----------------------------------------------------------------------------------------

pirvs_status Slam::feed(const pirvs_imu& sample) {
  if (life_ != Life::kRuns || in_callback) return refuse(PIRVS_REFUSED, "it does not run");
  ImuSample imu;
  imu.t = sample.t_ns;
  imu.w_B = Vec3(sample.w_rad_s[0], sample.w_rad_s[1], sample.w_rad_s[2]);
  imu.f_B = Vec3(sample.f_m_s2[0], sample.f_m_s2[1], sample.f_m_s2[2]);
  const bool taken = add(imu) == Status::kOk;
  ++(taken ? imu_fed_ : imu_lost_);
  if (stepped()) {
    drain();
  } else {
    bsp::wake(0);
  }
  return taken ? PIRVS_OK : PIRVS_FULL;
}

pirvs_status Slam::feed(const pirvs_images& images) {
  if (life_ != Life::kRuns || in_callback) return refuse(PIRVS_REFUSED, "it does not run");
  FedImages fed;
  fed.t = images.t_ns;
  fed.stride = images.stride != 0 ? static_cast<int>(images.stride) : calibration_.camera[0].width;
  for (int c = 0; c < calibration_.cameras; ++c) fed.image[c] = images.image[c];
  const bool taken = add(fed) == Status::kOk;
  ++(taken ? images_fed_ : images_lost_);
  if (stepped()) {
    drain();
  } else {
    bsp::wake(0);
  }
  return taken ? PIRVS_OK : PIRVS_FULL;
}

// ---- out, on the door's core -------------------------------------------------------------------

void Slam::give_out() {
  if (given_ < 0) return;
  while (const Pose* const pose = app.poses().next(given_)) {
    pirvs_pose out;
    fill(out, *pose, given_resets_.count(pose->trust.resets));
    call_back(config_.on_pose, out);
  }
}

void Slam::call_back(void (*to)(void*, const pirvs_pose*), const pirvs_pose& pose) const {
  in_callback = true;
  to(config_.context, &pose);
  in_callback = false;
}

void Slam::on_tracked(TimeNs t, const Tracker& tracker) {
  FusedState fused = {tracker.state(), tracker.cov(),    tracker.health(),  tracker.trust(),
                      tracker.epoch(), tracker.in_map(), tracker.running(), tracker.at_rest()};
  health_ = static_cast<uint8_t>(fused.health);
  confidence_ = fused.trust.confidence;
  reasons_ = fused.trust.reasons;
  in_map_ = fused.in_map;
  if (config_.points != 0) {
    Points& points = points_.back();
    points.t = t;
    points.count = app.seen_points(points.point, kPointsMax);
    points_.publish();
  }
  if (!fused.running) return;
  pirvs_pose& out = frames_.back();
  fill(out, pose_of(fused, t, w_B_), frame_resets_.count(fused.trust.resets));
  const pirvs_pose given = out;
  frames_.publish();
  if (config_.on_frame != nullptr) call_back(config_.on_frame, given);
}

void Slam::on_news(TimeNs t, HealthState state, const char* what) {
  health_ = static_cast<uint8_t>(state);
  pirvs_news& out = news_.back();
  out = pirvs_news{};
  out.size = sizeof out;
  out.health = static_cast<uint32_t>(state);
  out.t_ns = t;
  TextWriter text(out.text, sizeof out.text);
  text.put(what);
  const pirvs_news given = out;
  news_.publish();
  if (config_.on_news == nullptr) return;
  in_callback = true;
  config_.on_news(config_.context, &given);
  in_callback = false;
}

void Slam::on_answer(const Answer& answer) {
  const bool anew = answer.kind == CommandKind::kReset || answer.kind == CommandKind::kLoadMap;
  if (anew) frame_resets_.expect_another();
  answer_ = answer;
  answered_.store(answer.ticket + 1, std::memory_order_release);
}

// ---- out, for those who read -------------------------------------------------------------------

pirvs_status Slam::next_pose(int which, pirvs_pose& out) {
  if (which == PIRVS_AT_FRAME) {
    const pirvs_pose* const pose = frames_.take();
    if (pose == nullptr) return PIRVS_EMPTY;
    out = *pose;
    return PIRVS_OK;
  }
  if (which != PIRVS_AT_IMU) return refuse(PIRVS_BAD_ARGUMENT, "no such kind of poses");
  const Pose* const pose = taken_ >= 0 ? app.poses().next(taken_) : nullptr;
  if (pose == nullptr) return PIRVS_EMPTY;
  fill(out, *pose, taken_resets_.count(pose->trust.resets));
  return PIRVS_OK;
}

pirvs_status Slam::next_news(pirvs_news& out) {
  const pirvs_news* const news = news_.take();
  if (news == nullptr) return PIRVS_EMPTY;
  out = *news;
  return PIRVS_OK;
}

pirvs_status Slam::points(pirvs_points& out) {
  if (config_.points == 0) return refuse(PIRVS_REFUSED, "pirvs_config.points is 0");
  const Points* const points = points_.take();
  if (points == nullptr) return PIRVS_EMPTY;
  out.t_ns = points->t;
  out.count = 0;
  for (int i = 0; i < points->count && out.count < out.max; ++i) {
    const SeenPoint& seen = points->point[i];
    pirvs_point& to = out.point[out.count++];
    to.id = uint64_t{seen.id.generation} << 16 | seen.id.slot;
    copy(seen.p_W, to.p_m);
    to.sigma_m = seen.sigma_m;
  }
  return PIRVS_OK;
}

void Slam::state(pirvs_state& out) {
  out = pirvs_state{};
  out.size = sizeof out;
  const Life life = life_;
  out.health = health_;
  out.running = life == Life::kRuns ? 1 : 0;
  out.localised = in_map_ ? 1 : 0;
  out.confidence = confidence_;
  out.reasons = reasons_;
  out.imu_fed = imu_fed_;
  out.imu_lost = imu_lost_;
  out.images_fed = images_fed_;
  out.images_lost = images_lost_;
  out.frames_lost = frames_.lost();
  if (life == Life::kCreated) return;
  out.poses_lost = app.poses().lost(taken_);
  const LatencySummary latency = app.latency().imu_to_pose.summary();
  out.imu_to_pose_ms = latency.count > 0 ? static_cast<float>(latency.median_ms) : 0;
}

pirvs_status Slam::counter(int index, const char*& name, uint64_t& value) const {
  constexpr int kMax = 256;
  NamedValue values[kMax];
  const int count = life_ == Life::kCreated ? 0 : app.counters(values, kMax);
  if (index < 0 || index >= count) return PIRVS_EMPTY;
  name = values[index].name;
  value = values[index].value;
  return PIRVS_OK;
}

// ---- commands ----------------------------------------------------------------------------------

pirvs_status Slam::set_parameter(const char* name, float value) {
  if (life_ == Life::kCreated) {
    const ParamStatus status = pirvs::set_parameter(params_, name, value).status;
    if (status == ParamStatus::kOk) return PIRVS_OK;
    const bool unknown = status == ParamStatus::kNotFound || status == ParamStatus::kAmbiguous;
    return refuse(unknown ? PIRVS_NOT_FOUND : PIRVS_BAD_ARGUMENT, pirvs::name(status), name);
  }
  Command set;
  set.kind = CommandKind::kSetParameter;
  set.value = value;
  std::strncpy(set.text, name, sizeof set.text - 1);
  return command(set);
}

pirvs_status Slam::command(const Command& command) {
  if (in_callback) return refuse(PIRVS_REFUSED, "not from a callback");
  if (life_ != Life::kRuns) return refuse(PIRVS_REFUSED, "it does not run");
  pthread_mutex_lock(&commands_);
  const Result<uint32_t> ticket = app.command(command);
  pirvs_status status = PIRVS_FULL;
  if (ticket.ok()) {
    status = wait_for(ticket.value());
    if (status == PIRVS_OK) status = changed(answer_.status, name(command.kind));
  }
  pthread_mutex_unlock(&commands_);
  return status;
}

pirvs_status Slam::wait_for(uint32_t ticket) {
  if (stepped()) drain();
  const auto answered = [&] { return answered_.load(std::memory_order_acquire) == ticket + 1; };
  const TimeNs until = bsp::now() + (stepped() ? 0 : kAnswer_ns);
  while (!answered() && bsp::now() < until) bsp::relax();
  return answered() ? PIRVS_OK : refuse(PIRVS_TIMEOUT, "not obeyed in time");
}

pirvs_status Slam::changed(Status status, const char* what) {
  switch (status) {
    case Status::kOk:
      return PIRVS_OK;
    case Status::kNotFound:
      return refuse(PIRVS_NOT_FOUND, "no such file or parameter", what);
    case Status::kBadData:
      return refuse(PIRVS_BAD_DATA, "not a value that is allowed, or a damaged file", what);
    case Status::kStale:
      return refuse(PIRVS_REFUSED, "not possible now", what);
    default:
      return refuse(PIRVS_IO, pirvs::name(status), what);
  }
}

}  // namespace pirvs::board
