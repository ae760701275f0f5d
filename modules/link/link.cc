#include "modules/link/link.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/text.h"
#include "core/math/so3.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

using namespace mavlink;

constexpr TimeNs kSecond_ns = 1'000'000'000;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
// A velocity less certain than this is told as none: ArduPilot weighs all of them alike.
constexpr double kVelocitySigmaMax_m_s = 1;

void put(const Vec3& from, float (&to)[3]) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from(i));
}

// Upper triangle, by rows.
void put(const Mat6& from, float (&to)[21]) {
  int at = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) to[at++] = static_cast<float>(from(i, j));
  }
}

// PX4 refuses a quaternion that is off one by 1e-5 in float.
void put_quaternion(const Mat3& R, float (&wxyz)[4]) {
  const Vec4 q = quat_xyzw(R);
  constexpr int kXyzw[4] = {3, 0, 1, 2};
  float squares = 0;
  for (int i = 0; i < 4; ++i) {
    wxyz[i] = static_cast<float>(q(kXyzw[i]));
    squares += wxyz[i] * wxyz[i];
  }
  const float norm = std::sqrt(squares);
  for (float& x : wxyz) x /= norm;
}

template <size_t N>
void put_none(float (&to)[N]) {
  for (float& x : to) x = kNone;
}

bool is_known(const Mat3& cov_v) {
  return cov_v.diagonal().maxCoeff() <= kVelocitySigmaMax_m_s * kVelocitySigmaMax_m_s;
}

uint64_t micros(TimeNs t) { return t > 0 ? static_cast<uint64_t>(t) / 1000 : 0; }

uint8_t state_of(HealthState health) {
  switch (health) {
    case HealthState::kTracking:
      return kStateActive;
    case HealthState::kDegraded:
    case HealthState::kLost:
      return kStateCritical;
    default:
      return kStateStandby;
  }
}

uint8_t severity_of(HealthState health) {
  if (health == HealthState::kLost) return kCritical;
  return health == HealthState::kDegraded ? kWarning : kInfo;
}

uint8_t result_of(Status status) {
  switch (status) {
    case Status::kOk:
      return kAccepted;
    case Status::kFull:
    case Status::kStale:
      return kTemporarilyRejected;
    case Status::kBadData:
      return kDenied;
    default:
      return kFailed;
  }
}

double heading(const Mat3& R) { return arctan2(R(1, 0), R(0, 0)); }

double within_half_turn(double angle_rad) {
  return angle_rad - 2 * kPi * std::floor(angle_rad / (2 * kPi) + 0.5);
}

}  // namespace

// Dead reckoning is judged as tracking without correspondences is (docs/health.md): the confidence
// of the last frame says nothing about a camera that has gone silent since.
int8_t link_quality(const Pose& pose) {
  constexpr double kBlind = 0.5, kBlind_s = 0.5;
  if (pose.health == HealthState::kLost || !(pose.trust.confidence > 0)) return -1;
  double confidence = static_cast<double>(pose.trust.confidence);
  if (pose.dead_reckoning) {
    const double blind_s = to_seconds(pose.state.t - pose.t_frame);
    confidence = std::min(confidence, kBlind / (1 + blind_s / kBlind_s));
  }
  return static_cast<int8_t>(std::clamp(std::floor(100 * confidence + 0.5), 1.0, 100.0));
}

void Link::configure(const LinkSetup& setup, const ImuNoise& noise, const LinkStack& stack,
                     const LinkWire& wire) {
  *this = Link{};
  setup_ = setup;
  R_VB_ = mounting(setup.mounting_rad);
  // White noise of one sample; what is left of its bias is far below it.
  rate_variance_ = static_cast<float>(noise.gyro_noise * noise.gyro_noise * noise.rate_hz);
  stack_ = stack;
  wire_ = wire;
  sender_.system = static_cast<uint8_t>(setup.system);
  sender_.component = kComponent;
}

// ---- out ---------------------------------------------------------------------------------------

template <class Message>
bool Link::send(const Message& message) {
  uint8_t bytes[kFrameMax];
  const size_t size = encode(message, sender_, bytes);
  const bool sent = wire_.send(wire_.context, bytes, size);
  ++(sent ? counters_.sent : counters_.dropped);
  return sent;
}

void Link::send_odometry(const Pose& pose, const VehiclePose& vehicle) {
  Odometry out;
  out.time_usec = micros(pose.state.t);
  out.frame_id = setup_.frame == LinkFrame::kLocalNed ? kFrameLocalNed : kFrameLocalFrd;
  put(vehicle.p_LD, out.x_m);
  put_quaternion(vehicle.R_LD, out.q_wxyz);
  put(vehicle.w_D, out.rates_rad_s);
  put(vehicle.cov_pose, out.pose_covariance);
  if (is_known(vehicle.cov_v_D)) {
    put(vehicle.v_D, out.v_m_s);
    Mat6 cov = Mat6::Zero();
    cov.topLeftCorner<3, 3>() = vehicle.cov_v_D;
    cov.diagonal().tail<3>().setConstant(static_cast<double>(rate_variance_));
    put(cov, out.velocity_covariance);
  } else {
    put_none(out.v_m_s);
    put_none(out.velocity_covariance);
  }
  out.reset_counter = static_cast<uint8_t>(pose.trust.resets);
  out.quality = link_quality(pose);
  counters_.poses += send(out);
}

void Link::send_vision(const Pose& pose, const VehiclePose& vehicle) {
  VisionPositionEstimate place;
  place.usec = micros(pose.state.t);
  put(vehicle.p_LD, place.x_m);
  put(roll_pitch_yaw(vehicle.R_LD), place.roll_pitch_yaw_rad);
  put(vehicle.cov_pose, place.covariance);
  place.reset_counter = static_cast<uint8_t>(pose.trust.resets);
  counters_.poses += send(place);
  if (!is_known(vehicle.cov_v_LD)) return;
  VisionSpeedEstimate speed;
  speed.usec = place.usec;
  put(vehicle.v_LD, speed.v_m_s);
  for (int i = 0; i < 9; ++i) {
    speed.covariance[i] = static_cast<float>(vehicle.cov_v_LD(i / 3, i % 3));
  }
  speed.reset_counter = place.reset_counter;
  (void)send(speed);
}

void Link::pose(const Pose& pose) {
  newest_ = pose;
  has_pose_ = true;
  health_ = pose.health;
  constexpr TimeNs kEarly_ns = 1'000'000;  // the IMU's stamps vary by less
  const auto period_ns = from_seconds(1 / setup_.rate_hz);
  const TimeNs t = pose.state.t, late_ns = t - pose_t_;
  if (late_ns < -kEarly_ns && late_ns >= -period_ns - kEarly_ns) return;
  // Where time ran back, or on by more than a period, the rhythm begins anew.
  const bool in_time = late_ns >= -kEarly_ns && late_ns <= period_ns;
  pose_t_ = (in_time ? pose_t_ : t) + period_ns;
  const VehiclePose vehicle = vehicle_pose(pose, R_VB_);
  if (setup_.messages == LinkMessages::kOdometry) {
    send_odometry(pose, vehicle);
  } else {
    send_vision(pose, vehicle);
  }
}

// A text longer than a message comes in parts of one id; a zero ends the last one.
void Link::health(HealthState state, const char* what) {
  health_ = state;
  Text<128> text;
  text.put("PIRVS ").put(name(state)).put(": ").put(what);
  const bool whole = text.size() <= StatusText::kTextMax;
  if (!whole && ++text_id_ == 0) ++text_id_;  // 0: there is one part
  for (size_t at = 0; at == 0 || (!whole && at <= text.size()); at += StatusText::kTextMax) {
    StatusText out;
    out.severity = severity_of(state);
    out.id = whole ? uint16_t{0} : text_id_;
    out.chunk_seq = static_cast<uint8_t>(at / StatusText::kTextMax);
    std::memcpy(out.text, text.c_str() + at, std::min(text.size() - at, StatusText::kTextMax));
    (void)send(out);
  }
}

void Link::poll(TimeNs now) {
  if (now >= heartbeat_t_ || heartbeat_t_ - now > kSecond_ns) {
    heartbeat_t_ = now + kSecond_ns;
    Heartbeat out;
    out.system_status = state_of(health_);
    (void)send(out);
  }
  const bool alone = autopilot_component_ == 0;
  if (!alone && (now >= ask_t_ || ask_t_ - now > kSecond_ns)) {
    ask_t_ = now + kSecond_ns;
    Timesync question;
    question.ts1_ns = now;
    question.target_system = autopilot_system_;
    question.target_component = autopilot_component_;
    peer_clock_.ask(now);
    (void)send(question);
  }
}

// ---- in ----------------------------------------------------------------------------------------

bool Link::is_for_us(uint8_t target_system, uint8_t target_component) const {
  return (target_system == kEverybody || target_system == sender_.system) &&
         (target_component == kEverybody || target_component == kComponent);
}

void Link::receive(TimeNs now, const uint8_t* bytes, size_t size) {
  while (size > 0) {
    const size_t taken = parser_.push(bytes, size);
    while (parser_.next(frame_)) take(now, frame_);
    bytes += taken;
    size -= taken;
  }
}

void Link::deliver(Counter& counter, const Arrival& arrival) {
  ++(stack_.deliver(stack_.context, arrival) == Status::kOk ? counter : counters_.sensors_refused);
}

void Link::take(TimeNs now, const Frame& frame) {
  Heartbeat heartbeat;
  GpsRawInt raw;
  GpsInput input;
  WheelDistance distance;
  Status status = Status::kEmpty;
  GnssFix fix;
  WheelSample wheel;
  if (frame.id == Timesync::kKind.id) return take_timesync(now, frame);
  if (frame.id == CommandLong::kKind.id) return take_command(frame);
  if (decode(frame, heartbeat)) {
    if (heartbeat.autopilot == kAutopilotInvalid) return;
    autopilot_system_ = frame.system;
    autopilot_component_ = frame.component;
  } else if (decode(frame, raw)) {
    status = sensors_.take(now, peer_clock_, raw, fix);
    if (status == Status::kOk) deliver(counters_.fixes, arrival_of(fix));
  } else if (decode(frame, input)) {
    status = sensors_.take(now, peer_clock_, input, fix);
    if (status == Status::kOk) deliver(counters_.fixes, arrival_of(fix));
  } else if (decode(frame, distance)) {
    status = sensors_.take(now, peer_clock_, distance, wheel);
    if (status == Status::kOk) deliver(counters_.wheels, arrival_of(wheel));
  }
  counters_.sensors_refused += status != Status::kOk && status != Status::kEmpty;
}

void Link::take_timesync(TimeNs now, const Frame& frame) {
  Timesync message;
  if (!decode(frame, message) || !is_for_us(message.target_system, message.target_component)) {
    return;
  }
  if (message.tc1_ns != 0) {
    if (frame.system == autopilot_system_ && frame.component == autopilot_component_) {
      peer_clock_.answered(now, message.ts1_ns, message.tc1_ns);
    }
    return;
  }
  Timesync answer;
  answer.tc1_ns = now;
  answer.ts1_ns = message.ts1_ns;
  answer.target_system = frame.system;
  answer.target_component = frame.component;
  counters_.times_told += send(answer);
}

// ---- commands ----------------------------------------------------------------------------------

void Link::acknowledge(const Pending& to, uint8_t result) {
  counters_.commands_refused += result != kAccepted && result != kInProgress;
  CommandAck out;
  out.command = to.command;
  out.result = result;
  out.target_system = to.system;
  out.target_component = to.component;
  (void)send(out);
}

// What is told to all components is nobody's order to us: a reset loses the map.
void Link::take_command(const Frame& frame) {
  CommandLong message;
  if (!decode(frame, message) || message.target_component != kComponent ||
      !is_for_us(message.target_system, message.target_component)) {
    return;
  }
  ++counters_.commands;
  execute(message, frame);
}

void Link::execute(const CommandLong& message, const Frame& frame) {
  Pending asked;
  asked.command = message.command;
  asked.system = frame.system;
  asked.component = frame.component;
  Command command;
  if (message.command == kCommandReset) {
    command.kind = CommandKind::kReset;
  } else if (message.command == kCommandSetPose) {
    if (!has_pose_) return acknowledge(asked, kTemporarilyRejected);
    // The stack turns the heading of the IMU's x axis.
    constexpr double kUpright = 0.87;  // within 30 degrees of the vertical
    if (std::fabs(newest_.state.T_WB.R(2, 0)) > kUpright) return acknowledge(asked, kDenied);
    command = set_pose_command(message);
  } else {
    return acknowledge(asked, kUnsupported);
  }
  Pending* free = nullptr;
  for (Pending& other : pending_) {
    if (other.ticket_1 == 0) {
      free = &other;
    } else if (other.command == asked.command && other.system == asked.system &&
               other.component == asked.component) {
      return acknowledge(asked, kInProgress);  // asked again, for want of our answer
    }
  }
  const Result<uint32_t> ticket =
      free != nullptr ? stack_.command(stack_.context, command) : Result<uint32_t>(Status::kFull);
  if (!ticket.ok()) return acknowledge(asked, result_of(ticket.status()));
  *free = asked;
  free->ticket_1 = ticket.value() + 1;
}

// Parameters 1 to 4: place in m in L, heading of the vehicle in degrees, clockwise; NaN: as it is.
// The IMU is to turn by as much as the vehicle.
Command Link::set_pose_command(const CommandLong& message) const {
  constexpr double kDegree_rad = kPi / 180;
  const Mat3& R_WB = newest_.state.T_WB.R;
  const double now_rad = heading(R_WB * R_VB_.transpose());
  const auto wanted_deg = static_cast<double>(message.param[3]);
  const double wanted_rad = std::isnan(wanted_deg) ? now_rad : -kDegree_rad * wanted_deg;
  Command out;
  out.kind = CommandKind::kSetPose;
  for (int i = 0; i < 3; ++i) out.p_WB(i) = static_cast<double>(message.param[i]);
  out.p_WB = turned_over() * out.p_WB;
  out.yaw_rad = within_half_turn(heading(R_WB) + wanted_rad - now_rad);
  return out;
}

void Link::answer(const Answer& answer) {
  for (Pending& pending : pending_) {
    if (pending.ticket_1 != answer.ticket + 1) continue;
    acknowledge(pending, result_of(answer.status));
    pending = Pending{};
  }
}

}  // namespace pirvs
