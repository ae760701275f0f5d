#include "modules/link/mavlink_messages.h"

#include <cstring>

#include "core/base/assert.h"

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they lie");

namespace pirvs::mavlink {
namespace {

// Copies fields one behind the other: out of a message, or into it.
class Put {
 public:
  explicit Put(uint8_t* to) : to_(to) {}
  template <class... Fields>
  void operator()(const Fields&... fields) {
    (put(&fields, sizeof fields), ...);
  }
  size_t size() const { return size_; }

 private:
  void put(const void* field, size_t size) {
    std::memcpy(to_ + size_, field, size);
    size_ += size;
  }
  uint8_t* to_;
  size_t size_ = 0;
};

class Get {
 public:
  explicit Get(const uint8_t* from) : from_(from) {}
  template <class... Fields>
  void operator()(Fields&... fields) {
    (get(&fields, sizeof fields), ...);
  }

 private:
  void get(void* field, size_t size) {
    std::memcpy(field, from_, size);
    from_ += size;
  }
  const uint8_t* from_;
};

// What lies where: all fields of a message in the order of the wire. M is const or not.
template <class Wire, class M>
void fields(Wire& wire, M& m, const Heartbeat&) {
  wire(m.custom_mode, m.type, m.autopilot, m.base_mode, m.system_status, m.mavlink_version);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const GpsRawInt&) {
  wire(m.time_usec, m.lat_1e7_deg, m.lon_1e7_deg, m.alt_mm, m.eph, m.epv, m.vel_cm_s, m.cog_1e2_deg,
       m.fix_type, m.satellites_visible);
  wire(m.alt_ellipsoid_mm, m.h_acc_mm, m.v_acc_mm, m.vel_acc_mm_s, m.hdg_acc_1e5_deg,
       m.yaw_1e2_deg);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const CommandLong&) {
  wire(m.param, m.command, m.target_system, m.target_component, m.confirmation);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const CommandAck&) {
  wire(m.command, m.result, m.progress, m.result_param2, m.target_system, m.target_component);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const VisionPositionEstimate&) {
  wire(m.usec, m.x_m, m.roll_pitch_yaw_rad, m.covariance, m.reset_counter);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const VisionSpeedEstimate&) {
  wire(m.usec, m.v_m_s, m.covariance, m.reset_counter);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const Timesync&) {
  wire(m.tc1_ns, m.ts1_ns, m.target_system, m.target_component);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const GpsInput&) {
  wire(m.time_usec, m.time_week_ms, m.lat_1e7_deg, m.lon_1e7_deg, m.alt_m, m.hdop, m.vdop,
       m.v_ned_m_s, m.speed_accuracy_m_s, m.horiz_accuracy_m, m.vert_accuracy_m);
  wire(m.ignore_flags, m.time_week, m.gps_id, m.fix_type, m.satellites_visible, m.yaw_1e2_deg);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const StatusText&) {
  wire(m.severity, m.text, m.id, m.chunk_seq);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const Odometry&) {
  wire(m.time_usec, m.x_m, m.q_wxyz, m.v_m_s, m.rates_rad_s, m.pose_covariance,
       m.velocity_covariance);
  wire(m.frame_id, m.child_frame_id, m.reset_counter, m.estimator_type, m.quality);
}

template <class Wire, class M>
void fields(Wire& wire, M& m, const WheelDistance&) {
  wire(m.time_usec, m.distance_m, m.count);
}

constexpr MessageKind kKinds[] = {
    Heartbeat::kKind,
    GpsRawInt::kKind,
    CommandLong::kKind,
    CommandAck::kKind,
    VisionPositionEstimate::kKind,
    VisionSpeedEstimate::kKind,
    Timesync::kKind,
    GpsInput::kKind,
    StatusText::kKind,
    Odometry::kKind,
    WheelDistance::kKind,
};

}  // namespace

const MessageKind* find_kind(uint32_t id) {
  for (const MessageKind& kind : kKinds) {
    if (kind.id == id) return &kind;
  }
  return nullptr;
}

template <class Message>
size_t encode(const Message& message, Sender& sender, uint8_t (&out)[kFrameMax]) {
  uint8_t payload[kPayloadMax];
  Put put(payload);
  fields(put, message, message);
  PIRVS_ASSERT(put.size() == Message::kKind.size);
  return write_frame(Message::kKind, payload, sender, out);
}

template <class Message>
bool decode(const Frame& frame, Message& out) {
  if (frame.id != Message::kKind.id) return false;
  Get get(frame.payload);
  fields(get, out, out);
  return true;
}

template size_t encode(const Heartbeat&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const GpsRawInt&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const CommandLong&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const CommandAck&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const VisionPositionEstimate&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const VisionSpeedEstimate&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const Timesync&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const GpsInput&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const StatusText&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const Odometry&, Sender&, uint8_t (&)[kFrameMax]);
template size_t encode(const WheelDistance&, Sender&, uint8_t (&)[kFrameMax]);
template bool decode(const Frame&, Heartbeat&);
template bool decode(const Frame&, GpsRawInt&);
template bool decode(const Frame&, CommandLong&);
template bool decode(const Frame&, CommandAck&);
template bool decode(const Frame&, VisionPositionEstimate&);
template bool decode(const Frame&, VisionSpeedEstimate&);
template bool decode(const Frame&, Timesync&);
template bool decode(const Frame&, GpsInput&);
template bool decode(const Frame&, StatusText&);
template bool decode(const Frame&, Odometry&);
template bool decode(const Frame&, WheelDistance&);

}  // namespace pirvs::mavlink
