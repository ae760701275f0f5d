// Encodes and decodes the datagrams of the device. docs/device.md, "Stream", describes the same
// format as a table, for programs that are not ours.
//
// Every datagram begins with 16 bytes: magic "PVS1" (the format's version in it), kind, flags (0),
// part and parts (2 bytes each): a message longer than a datagram comes in parts; sequence: counted
// by the sender for each receiver and over all kinds, so that a step tells what was lost; size of
// what follows. All numbers are little-endian.
// In      Values to write, with room for kDatagramMax bytes; a datagram that came.
// Out     encode: the datagram's size. decode: the value.
// Frames  as Pose and FusedPose have them.
// Units   m, rad, s; times in ns on CLOCK_MONOTONIC of the device.
// Errors  decode: false: too short, another version, another kind, or a value that cannot be.
// Cost    ~0.3 us a datagram.
// Source  own.
#pragma once

#include "bsp/api/datagram.h"
#include "bsp/api/imu.h"
#include "core/base/text.h"
#include "modules/fusion/fused_pose.h"
#include "modules/output/pose.h"

namespace pirvs::stream {

inline constexpr size_t kMax = bsp::kDatagramMax;

enum class Kind : uint8_t {
  kPose = 1,
  kHealth,          // a change, and why
  kCounters,        // text: `name value` lines, in parts
  kPoints,          // landmarks that are tracked now
  kThumbnail,       // of the left camera, in parts
  kSyncIn,          // an edge of SYNC_IN, and the pose at its time
  kClock,           // answer to kAskClock
  kPps,             // the external clock, at each of its pulses
  kFused,           // the pose on the Earth, at each frame and fix
  kImu,             // a sample as it was measured
  kSubscribe = 32,  // to the device: send me these kinds for so long
  kAskClock,        // to the device: what time is it?
};

struct Header {
  Kind kind = Kind::kPose;
  uint16_t part = 0, parts = 1;
  uint32_t sequence = 0;
  uint16_t size = 0;
};
inline constexpr size_t kHeaderBytes = 16;

struct PoseMessage {
  TimeNs t = 0, t_published = 0, t_frame = 0;
  Vec3 p_WB = Vec3::Zero(), v_WB = Vec3::Zero(), w_B = Vec3::Zero();
  Vec4 q_xyzw = Vec4(0, 0, 0, 1);
  Mat6 cov_theta_p = Mat6::Zero();
  Mat3 cov_v = Mat3::Zero();
  HealthState health = HealthState::kInitializing;
  float confidence = 0;
  uint32_t resets = 0;
  uint16_t epoch = 0;
  bool dead_reckoning = false;
  bool in_map = false;  // the pose stands in the frame of the map that was loaded
};

struct HealthMessage {
  TimeNs t = 0;
  HealthState health = HealthState::kInitializing;
  Text<128> why;
};

struct Point {
  uint32_t id = 0;
  Eigen::Vector3f p_W = Eigen::Vector3f::Zero();
  float sigma_m = 0;  // of its worst direction
};
inline constexpr int kPointsMax = 70;  // a part

struct PointsMessage {
  TimeNs t = 0;
  uint16_t epoch = 0;
  int count = 0;
  Point points[kPointsMax];
};

inline constexpr size_t kPixelsMax = kMax - kHeaderBytes - 20;
struct ThumbnailMessage {
  TimeNs t = 0;
  uint16_t width = 0, height = 0;
  uint32_t offset = 0;  // of this part's first pixel
  uint16_t count = 0;
  uint8_t pixels[kPixelsMax];
};

struct SyncInMessage {
  TimeNs t = 0;
  bool level = false, has_pose = false;
  PoseMessage pose;
};

// SYNC_IN as a pulse per second: seconds of the external clock begin at t + k (1 s + rate_ppb ns).
struct PpsMessage {
  TimeNs t = 0;         // when its newest second began
  double rate_ppb = 0;  // by how much the device's clock is fast
  float noise_ns = 0;   // rms of its pulses about that line
  uint32_t pulses = 0;  // that were counted, and that were no second
  uint32_t odd = 0;
};

struct ClockMessage {
  TimeNs t_host = 0;    // as it was asked
  TimeNs t_device = 0;  // when it was answered
};

struct SubscribeMessage {
  uint32_t kinds = 0;  // bit k: kind k
  uint16_t lease_s = 0;
};
constexpr uint32_t bit(Kind kind) { return 1u << static_cast<int>(kind); }

[[nodiscard]] bool decode(const uint8_t* bytes, size_t size, Header& out);

size_t encode(const Pose& pose, uint32_t sequence, uint8_t* out);
size_t encode(const HealthMessage& message, uint32_t sequence, uint8_t* out);
size_t encode(const PointsMessage& message, const Header& header, uint8_t* out);
size_t encode(const ThumbnailMessage& message, const Header& header, uint8_t* out);
// `pose`: nullptr: there is none.
size_t encode(TimeNs t, bool level, const Pose* pose, uint32_t sequence, uint8_t* out);
size_t encode(const PpsMessage& message, uint32_t sequence, uint8_t* out);
// Between position and velocity, and attitude and velocity, no covariance goes out.
size_t encode(const FusedPose& pose, uint32_t sequence, uint8_t* out);
size_t encode(const ImuSample& sample, uint32_t sequence, uint8_t* out);
size_t encode(const ClockMessage& message, Kind kind, uint32_t sequence, uint8_t* out);
size_t encode(const SubscribeMessage& message, uint8_t* out);
// Text as it is; the caller keeps it below kMax - kHeaderBytes.
size_t encode_text(const TextWriter& text, const Header& header, uint8_t* out);

// Of a datagram whose header was decoded, after the header.
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, PoseMessage& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, HealthMessage& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, PointsMessage& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, ThumbnailMessage& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, SyncInMessage& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, PpsMessage& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, FusedPose& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, ImuSample& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, ClockMessage& out);
[[nodiscard]] bool decode(const Header& header, const uint8_t* payload, SubscribeMessage& out);

}  // namespace pirvs::stream
