// The messages of MAVLink 2 that the link speaks and understands. Fields stand in the order of the
// wire: by size, those of extensions behind.
// In      encode(): a message. decode(): a frame that FrameParser has found.
// Out     encode: the frame's size. decode: the message; fields that were not sent are 0.
// Units   as MAVLink has them; they end the names. Angles of COMMAND_LONG as its command says.
// Errors  decode: false: a frame of another message.
// Cost    ~0.2 us a message.
// Source  mavlink/message_definitions, common.xml; ids, CRC_EXTRA and sizes as its generators give
//         them.
#pragma once

#include "modules/link/mavlink_frame.h"

namespace pirvs::mavlink {

// Who speaks here: a visual inertial odometry (MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY).
inline constexpr uint8_t kComponent = 197;
inline constexpr uint8_t kEverybody = 0;  // as a target

enum : uint8_t { kTypeOnboardController = 18 };                                  // MAV_TYPE
enum : uint8_t { kAutopilotInvalid = 8 };                                        // MAV_AUTOPILOT
enum : uint8_t { kStateStandby = 3, kStateActive = 4, kStateCritical = 5 };      // MAV_STATE
enum : uint8_t { kFrameLocalNed = 1, kFrameBodyFrd = 12, kFrameLocalFrd = 20 };  // MAV_FRAME
enum : uint8_t { kEstimatorVio = 3 };                                // MAV_ESTIMATOR_TYPE
enum : uint8_t { kCritical = 2, kWarning = 4, kInfo = 6 };           // MAV_SEVERITY
enum : uint16_t { kCommandReset = 31010, kCommandSetPose = 31011 };  // MAV_CMD_USER_1, _2
enum : uint8_t {                                                     // MAV_RESULT
  kAccepted,
  kTemporarilyRejected,
  kDenied,
  kUnsupported,
  kFailed,
  kInProgress
};

struct Heartbeat {
  static constexpr MessageKind kKind = {0, 50, 9};
  uint32_t custom_mode = 0;
  uint8_t type = kTypeOnboardController, autopilot = kAutopilotInvalid, base_mode = 0;
  uint8_t system_status = 0, mavlink_version = 3;
};

struct GpsRawInt {
  static constexpr MessageKind kKind = {24, 24, 52};
  uint64_t time_usec = 0;
  int32_t lat_1e7_deg = 0, lon_1e7_deg = 0, alt_mm = 0;      // above the sea
  uint16_t eph = 0, epv = 0, vel_cm_s = 0, cog_1e2_deg = 0;  // dilutions in hundredths
  uint8_t fix_type = 0, satellites_visible = 0;
  int32_t alt_ellipsoid_mm = 0;
  uint32_t h_acc_mm = 0, v_acc_mm = 0, vel_acc_mm_s = 0, hdg_acc_1e5_deg = 0;
  uint16_t yaw_1e2_deg = 0;
};

struct CommandLong {
  static constexpr MessageKind kKind = {76, 152, 33};
  float param[7] = {};
  uint16_t command = 0;
  uint8_t target_system = 0, target_component = 0, confirmation = 0;
};

struct CommandAck {
  static constexpr MessageKind kKind = {77, 143, 10};
  uint16_t command = 0;
  uint8_t result = 0, progress = 0;
  int32_t result_param2 = 0;
  uint8_t target_system = 0, target_component = 0;
};

struct VisionPositionEstimate {
  static constexpr MessageKind kKind = {102, 158, 117};
  uint64_t usec = 0;
  float x_m[3] = {}, roll_pitch_yaw_rad[3] = {};
  float covariance[21] = {};  // of both, upper triangle by rows
  uint8_t reset_counter = 0;
};

struct VisionSpeedEstimate {
  static constexpr MessageKind kKind = {103, 208, 57};
  uint64_t usec = 0;
  float v_m_s[3] = {};
  float covariance[9] = {};
  uint8_t reset_counter = 0;
};

struct Timesync {
  static constexpr MessageKind kKind = {111, 34, 18};
  int64_t tc1_ns = 0;  // 0: a question, when sent at ts1
  int64_t ts1_ns = 0;
  uint8_t target_system = 0, target_component = 0;
};

struct GpsInput {
  static constexpr MessageKind kKind = {232, 151, 65};
  // ignore_flags
  enum : uint16_t { kNoAltitude = 1, kNoSpeed = 8 | 16, kNoSpeedSigma = 32, kNoSigmas = 64 | 128 };
  uint64_t time_usec = 0;
  uint32_t time_week_ms = 0;
  int32_t lat_1e7_deg = 0, lon_1e7_deg = 0;
  float alt_m = 0, hdop = 0, vdop = 0, v_ned_m_s[3] = {};
  float speed_accuracy_m_s = 0, horiz_accuracy_m = 0, vert_accuracy_m = 0;
  uint16_t ignore_flags = 0, time_week = 0;
  uint8_t gps_id = 0, fix_type = 0, satellites_visible = 0;
  uint16_t yaw_1e2_deg = 0;
};

struct StatusText {
  static constexpr MessageKind kKind = {253, 83, 54};
  static constexpr size_t kTextMax = 50;
  uint8_t severity = kInfo;
  char text[kTextMax] = {};  // ends with 0 where there is room
  uint16_t id = 0;
  uint8_t chunk_seq = 0;
};

struct Odometry {
  static constexpr MessageKind kKind = {331, 91, 233};
  uint64_t time_usec = 0;
  float x_m[3] = {};
  float q_wxyz[4] = {1, 0, 0, 0};
  float v_m_s[3] = {}, rates_rad_s[3] = {};  // in the child's frame
  float pose_covariance[21] = {};            // of x y z roll pitch yaw, upper triangle by rows
  float velocity_covariance[21] = {};
  uint8_t frame_id = kFrameLocalFrd, child_frame_id = kFrameBodyFrd;
  uint8_t reset_counter = 0, estimator_type = kEstimatorVio;
  int8_t quality = 0;  // -1 failed, 0 unknown, 1 to 100
};

struct WheelDistance {
  static constexpr MessageKind kKind = {9000, 113, 137};
  static constexpr int kWheelsMax = 16;
  uint64_t time_usec = 0;
  double distance_m[kWheelsMax] = {};  // each wheel's way so far, forward counts up
  uint8_t count = 0;
};

// nullptr: none of the above.
const MessageKind* find_kind(uint32_t id);

// Of each message above.
template <class Message>
size_t encode(const Message& message, Sender& sender, uint8_t (&out)[kFrameMax]);
template <class Message>
[[nodiscard]] bool decode(const Frame& frame, Message& out);

}  // namespace pirvs::mavlink
