// The robot's link: poses to an autopilot in MAVLink 2, and what it knows and wants from us.
// In      pose(): every pose of the feed. health(): each change. answer(): the stack's answer to a
//         command. receive(): bytes from the other side, as they come. poll(): ten times a second
//         at least. All from one core; `now`: on the clock of the poses' stamps.
// Out     LinkWire::send, one whole frame a call: HEARTBEAT once a second, ODOMETRY (or
//         VISION_POSITION_ESTIMATE and VISION_SPEED_ESTIMATE) at the rate of the setup while there
//         are poses, STATUSTEXT at each change of health, TIMESYNC at once to whoever asks,
//         COMMAND_ACK. LinkStack: GNSS fixes (GPS_RAW_INT, GPS_INPUT), wheels (WHEEL_DISTANCE) and
//         the commands reset and set pose, for the door.
// Frames  vehicle_pose.h. Units: ns, m, rad; on the wire MAVLink's.
// Errors  Counted in LinkCounters. What cannot be sent now is lost; nothing is ever waited for.
// Cost    pose() ~3 us where one is sent, else ~10 ns; 3 kB.
// Source  mavlink.io: heartbeat, time synchronisation and command protocols; docs/integration.md.
#pragma once

#include "modules/door/arrival.h"
#include "modules/imu/imu_noise.h"
#include "modules/link/mavlink_messages.h"
#include "modules/link/peer_clock.h"
#include "modules/link/robot_sensors.h"
#include "modules/link/vehicle_pose.h"

namespace pirvs {

// kLocalFrd: north is unknown. kLocalNed: the x axis of W is said to point north.
enum class LinkFrame : uint8_t { kLocalFrd, kLocalNed };
// kVision: the two messages that came before ODOMETRY, without quality.
enum class LinkMessages : uint8_t { kOdometry, kVision };

struct LinkSetup {
  static constexpr double kRateMin_hz = 10, kRateMax_hz = 100;
  int system = 1;  // the vehicle's number
  double rate_hz = 50;
  LinkFrame frame = LinkFrame::kLocalFrd;
  LinkMessages messages = LinkMessages::kOdometry;
  Vec3 mounting_rad = Vec3::Zero();  // roll, pitch, yaw of the IMU's axes in V
};

// Who obeys and who takes what the robot's sensors say; either may refuse with kFull.
struct LinkStack {
  void* context = nullptr;
  Result<uint32_t> (*command)(void*, const Command&) = nullptr;  // the answer's ticket
  Status (*deliver)(void*, const Arrival&) = nullptr;
};

struct LinkWire {
  void* context = nullptr;
  bool (*send)(void*, const uint8_t* frame, size_t size) = nullptr;  // false: no room
};

struct LinkCounters {
  Counter sent, dropped, poses, times_told, fixes, wheels, sensors_refused, commands,
      commands_refused;
};
inline constexpr CounterRow<LinkCounters> kLinkRows[] = {
    {"sent", &LinkCounters::sent},              // frames
    {"dropped", &LinkCounters::dropped},        // no room for them
    {"poses", &LinkCounters::poses},            // among those sent
    {"times_told", &LinkCounters::times_told},  // TIMESYNC answered
    {"fixes", &LinkCounters::fixes},
    {"wheels", &LinkCounters::wheels},
    {"sensors_refused", &LinkCounters::sensors_refused},  // robot_sensors.h says why
    {"commands", &LinkCounters::commands},
    {"commands_refused", &LinkCounters::commands_refused},  // unknown, or not possible now
};
static_assert(every_counter_is_in(kLinkRows));

class Link {
 public:
  void configure(const LinkSetup& setup, const ImuNoise& noise, const LinkStack& stack,
                 const LinkWire& wire);

  void pose(const Pose& pose);
  void health(HealthState state, const char* what);
  void answer(const Answer& answer);
  void receive(TimeNs now, const uint8_t* bytes, size_t size);
  void poll(TimeNs now);

  const LinkCounters& counters() const { return counters_; }
  const mavlink::ParserCounters& parser_counters() const { return parser_.counters(); }

 private:
  static constexpr int kPendingMax = 4;
  static constexpr TimeNs kNever = INT64_MIN / 2;

  struct Pending {          // a command that the stack has not answered yet
    uint32_t ticket_1 = 0;  // + 1; 0: free
    uint16_t command = 0;
    uint8_t system = 0, component = 0;
  };

  template <class Message>
  bool send(const Message& message);
  void send_odometry(const Pose& pose, const VehiclePose& vehicle);
  void send_vision(const Pose& pose, const VehiclePose& vehicle);
  void take(TimeNs now, const mavlink::Frame& frame);
  void take_timesync(TimeNs now, const mavlink::Frame& frame);
  void take_command(const mavlink::Frame& frame);
  void execute(const mavlink::CommandLong& message, const mavlink::Frame& frame);
  Command set_pose_command(const mavlink::CommandLong& message) const;
  void acknowledge(const Pending& to, uint8_t result);
  void deliver(Counter& counter, const Arrival& arrival);
  bool is_for_us(uint8_t target_system, uint8_t target_component) const;

  LinkSetup setup_;
  Mat3 R_VB_ = Mat3::Identity();
  float rate_variance_ = 0;
  LinkStack stack_;
  LinkWire wire_;
  mavlink::Sender sender_;
  mavlink::FrameParser parser_;
  mavlink::Frame frame_;
  PeerClock peer_clock_;
  RobotSensors sensors_;
  HealthState health_ = HealthState::kInitializing;
  uint16_t text_id_ = 0;  // of the last text in parts
  Pose newest_;
  bool has_pose_ = false;
  TimeNs pose_t_ = kNever, heartbeat_t_ = kNever, ask_t_ = kNever;  // of the next ones
  uint8_t autopilot_system_ = 0, autopilot_component_ = 0;          // 0: none has been heard
  Pending pending_[kPendingMax];
  LinkCounters counters_;
};

// 1 to 100; -1: failed.
int8_t link_quality(const Pose& pose);

}  // namespace pirvs
