#include "modules/stream/stream.h"

#include <cmath>
#include <cstring>

#include "core/math/so3.h"

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they lie");

namespace pirvs::stream {
namespace {

constexpr uint32_t kMagic = 0x3153'5650;  // "PVS1"

class Writer {
 public:
  explicit Writer(uint8_t* out) : out_(out) {}
  template <class T>
  Writer& put(T value) {
    std::memcpy(out_ + size_, &value, sizeof value);
    size_ += sizeof value;
    return *this;
  }
  Writer& put_bytes(const void* from, size_t count) {
    std::memcpy(out_ + size_, from, count);
    size_ += count;
    return *this;
  }
  template <class Vector>
  Writer& put_doubles(const Vector& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) put(static_cast<double>(values(i)));
    return *this;
  }
  template <class Vector>
  Writer& put_floats(const Vector& values) {
    for (Eigen::Index i = 0; i < values.size(); ++i) put(static_cast<float>(values(i)));
    return *this;
  }
  // Upper triangle, by rows.
  template <class Matrix>
  Writer& put_symmetric(const Matrix& m) {
    for (Eigen::Index i = 0; i < m.rows(); ++i) {
      for (Eigen::Index j = i; j < m.cols(); ++j) put(static_cast<float>(m(i, j)));
    }
    return *this;
  }
  size_t size() const { return size_; }

 private:
  uint8_t* out_;
  size_t size_ = 0;
};

// What is read past the end is zero, and ok() says so.
class Reader {
 public:
  Reader(const uint8_t* bytes, size_t size) : bytes_(bytes), size_(size) {}
  template <class T>
  T get() {
    T value{};
    if (const uint8_t* const from = take(sizeof value)) std::memcpy(&value, from, sizeof value);
    return value;
  }
  template <class Vector>
  void get_doubles(Vector& out) {
    for (Eigen::Index i = 0; i < out.size(); ++i) out(i) = get<double>();
  }
  template <class Vector>
  void get_floats(Vector& out) {
    for (Eigen::Index i = 0; i < out.size(); ++i) out(i) = get<float>();
  }
  template <class Matrix>
  void get_symmetric(Matrix& out) {
    for (Eigen::Index i = 0; i < out.rows(); ++i) {
      for (Eigen::Index j = i; j < out.cols(); ++j) out(i, j) = out(j, i) = get<float>();
    }
  }
  // nullptr: there are not so many.
  const uint8_t* take(size_t count) {
    if (count > size_ - at_) {
      ok_ = false;
      return nullptr;
    }
    at_ += count;
    return bytes_ + at_ - count;
  }
  size_t left() const { return size_ - at_; }
  bool ok() const { return ok_; }

 private:
  const uint8_t* bytes_;
  size_t size_, at_ = 0;
  bool ok_ = true;
};

void put_header(Writer& out, const Header& header) {
  out.put(kMagic).put(static_cast<uint8_t>(header.kind)).put(uint8_t{0});
  out.put(header.part).put(header.parts).put(header.sequence).put(header.size);
}

// Writes the header, lets `fill` write the rest, and says in the header how much that was.
template <class Fill>
size_t write(Header header, uint8_t* out, Fill fill) {
  Writer body(out + kHeaderBytes);
  fill(body);
  header.size = static_cast<uint16_t>(body.size());
  Writer head(out);
  put_header(head, header);
  return kHeaderBytes + body.size();
}

Header plain(Kind kind, uint32_t sequence) {
  Header out;
  out.kind = kind;
  out.sequence = sequence;
  return out;
}

constexpr int kDeadReckoning = 1, kInMap = 2;

void put_pose(Writer& out, const Pose& pose) {
  out.put(pose.state.t).put(pose.t_published).put(pose.t_frame);
  out.put_doubles(pose.state.T_WB.p);
  out.put_floats(quat_xyzw(pose.state.T_WB.R)).put_floats(pose.state.v_WB).put_floats(pose.w_B);
  out.put_symmetric(pose.cov.topLeftCorner<6, 6>());
  out.put_symmetric(pose.cov.bottomRightCorner<3, 3>());
  out.put(pose.trust.confidence).put(pose.trust.resets).put(pose.epoch);
  const int flags = (pose.dead_reckoning ? kDeadReckoning : 0) | (pose.in_map ? kInMap : 0);
  out.put(static_cast<uint8_t>(pose.health)).put(static_cast<uint8_t>(flags));
}

bool get_health(Reader& in, HealthState& out) {
  const auto value = in.get<uint8_t>();
  if (value >= static_cast<uint8_t>(HealthState::kCount)) return false;
  out = static_cast<HealthState>(value);
  return true;
}

bool get_pose(Reader& in, PoseMessage& out) {
  out.t = in.get<TimeNs>();
  out.t_published = in.get<TimeNs>();
  out.t_frame = in.get<TimeNs>();
  in.get_doubles(out.p_WB);
  in.get_floats(out.q_xyzw);
  in.get_floats(out.v_WB);
  in.get_floats(out.w_B);
  in.get_symmetric(out.cov_theta_p);
  in.get_symmetric(out.cov_v);
  out.confidence = in.get<float>();
  out.resets = in.get<uint32_t>();
  out.epoch = in.get<uint16_t>();
  const bool known = get_health(in, out.health);
  const auto flags = in.get<uint8_t>();
  out.dead_reckoning = (flags & kDeadReckoning) != 0;
  out.in_map = (flags & kInMap) != 0;
  return in.ok() && known && out.p_WB.allFinite() && out.q_xyzw.allFinite() &&
         std::fabs(out.q_xyzw.norm() - 1) < 1e-3 && std::isfinite(out.confidence);
}

}  // namespace

bool decode(const uint8_t* bytes, size_t size, Header& out) {
  Reader in(bytes, size);
  if (in.get<uint32_t>() != kMagic) return false;
  out.kind = static_cast<Kind>(in.get<uint8_t>());
  (void)in.get<uint8_t>();
  out.part = in.get<uint16_t>();
  out.parts = in.get<uint16_t>();
  out.sequence = in.get<uint32_t>();
  out.size = in.get<uint16_t>();
  return in.ok() && out.part < out.parts && in.left() == out.size;
}

// ---- to bytes ----------------------------------------------------------------------------------

size_t encode(const Pose& pose, uint32_t sequence, uint8_t* out) {
  return write(plain(Kind::kPose, sequence), out, [&](Writer& body) { put_pose(body, pose); });
}

size_t encode(const HealthMessage& message, uint32_t sequence, uint8_t* out) {
  return write(plain(Kind::kHealth, sequence), out, [&](Writer& body) {
    body.put(message.t).put(static_cast<uint8_t>(message.health));
    body.put_bytes(message.why.c_str(), message.why.size());
  });
}

size_t encode(const PointsMessage& message, const Header& header, uint8_t* out) {
  return write(header, out, [&](Writer& body) {
    body.put(message.t).put(message.epoch);
    for (int i = 0; i < message.count; ++i) {
      const Point& point = message.points[i];
      body.put(point.id).put_floats(point.p_W).put(point.sigma_m);
    }
  });
}

size_t encode(const ThumbnailMessage& message, const Header& header, uint8_t* out) {
  return write(header, out, [&](Writer& body) {
    body.put(message.t).put(message.width).put(message.height).put(message.offset);
    body.put_bytes(message.pixels, message.count);
  });
}

size_t encode(TimeNs t, bool level, const Pose* pose, uint32_t sequence, uint8_t* out) {
  return write(plain(Kind::kSyncIn, sequence), out, [&](Writer& body) {
    body.put(t).put(static_cast<uint8_t>(level)).put(static_cast<uint8_t>(pose != nullptr));
    if (pose != nullptr) put_pose(body, *pose);
  });
}

size_t encode(const PpsMessage& message, uint32_t sequence, uint8_t* out) {
  return write(plain(Kind::kPps, sequence), out, [&](Writer& body) {
    body.put(message.t).put(message.rate_ppb).put(message.noise_ns);
    body.put(message.pulses).put(message.odd);
  });
}

size_t encode(const FusedPose& pose, uint32_t sequence, uint8_t* out) {
  return write(plain(Kind::kFused, sequence), out, [&](Writer& body) {
    body.put(pose.t).put_doubles(pose.T_EB.p);
    body.put(pose.place.latitude_rad).put(pose.place.longitude_rad).put(pose.place.height_m);
    body.put_doubles(quat_xyzw(pose.T_EB.R)).put_floats(pose.v_EB);
    body.put_symmetric(pose.cov.topLeftCorner<6, 6>());
    body.put_symmetric(pose.cov.bottomRightCorner<3, 3>());
    body.put(pose.confidence).put(pose.resets).put(static_cast<uint8_t>(pose.health));
    body.put(pose.sources).put(static_cast<uint8_t>(pose.has_heading));
  });
}

size_t encode(const ImuSample& sample, uint32_t sequence, uint8_t* out) {
  return write(plain(Kind::kImu, sequence), out, [&](Writer& body) {
    body.put(sample.t).put_doubles(sample.w_B).put_doubles(sample.f_B);
  });
}

size_t encode(const ClockMessage& message, Kind kind, uint32_t sequence, uint8_t* out) {
  return write(plain(kind, sequence), out,
               [&](Writer& body) { body.put(message.t_host).put(message.t_device); });
}

size_t encode(const SubscribeMessage& message, uint8_t* out) {
  return write(plain(Kind::kSubscribe, 0), out,
               [&](Writer& body) { body.put(message.kinds).put(message.lease_s); });
}

size_t encode_text(const TextWriter& text, const Header& header, uint8_t* out) {
  return write(header, out, [&](Writer& body) { body.put_bytes(text.c_str(), text.size()); });
}

// ---- from bytes --------------------------------------------------------------------------------

bool decode(const Header& header, const uint8_t* payload, PoseMessage& out) {
  Reader in(payload, header.size);
  return header.kind == Kind::kPose && get_pose(in, out) && in.left() == 0;
}

bool decode(const Header& header, const uint8_t* payload, HealthMessage& out) {
  Reader in(payload, header.size);
  out.t = in.get<TimeNs>();
  const bool known = get_health(in, out.health);
  out.why.clear();
  const size_t length = in.left();
  const uint8_t* const why = in.take(length);
  for (size_t i = 0; i < length; ++i) out.why.put(static_cast<char>(why[i]));
  return header.kind == Kind::kHealth && in.ok() && known && !out.why.full();
}

bool decode(const Header& header, const uint8_t* payload, PointsMessage& out) {
  constexpr size_t kPointBytes = 20;
  Reader in(payload, header.size);
  out.t = in.get<TimeNs>();
  out.epoch = in.get<uint16_t>();
  if (header.kind != Kind::kPoints || !in.ok() || in.left() % kPointBytes != 0) return false;
  const size_t count = in.left() / kPointBytes;
  if (count > size_t{kPointsMax}) return false;
  out.count = static_cast<int>(count);
  for (int i = 0; i < out.count; ++i) {
    Point& point = out.points[i];
    point.id = in.get<uint32_t>();
    in.get_floats(point.p_W);
    point.sigma_m = in.get<float>();
    if (!point.p_W.allFinite()) return false;
  }
  return true;
}

bool decode(const Header& header, const uint8_t* payload, ThumbnailMessage& out) {
  Reader in(payload, header.size);
  out.t = in.get<TimeNs>();
  out.width = in.get<uint16_t>();
  out.height = in.get<uint16_t>();
  out.offset = in.get<uint32_t>();
  if (header.kind != Kind::kThumbnail || !in.ok() || in.left() > kPixelsMax) return false;
  out.count = static_cast<uint16_t>(in.left());
  std::memcpy(out.pixels, in.take(out.count), out.count);
  return size_t{out.offset} + out.count <= size_t{out.width} * out.height;
}

bool decode(const Header& header, const uint8_t* payload, SyncInMessage& out) {
  Reader in(payload, header.size);
  out.t = in.get<TimeNs>();
  out.level = in.get<uint8_t>() != 0;
  out.has_pose = in.get<uint8_t>() != 0;
  if (header.kind != Kind::kSyncIn || !in.ok()) return false;
  return (!out.has_pose || get_pose(in, out.pose)) && in.left() == 0;
}

bool decode(const Header& header, const uint8_t* payload, PpsMessage& out) {
  Reader in(payload, header.size);
  out.t = in.get<TimeNs>();
  out.rate_ppb = in.get<double>();
  out.noise_ns = in.get<float>();
  out.pulses = in.get<uint32_t>();
  out.odd = in.get<uint32_t>();
  return header.kind == Kind::kPps && in.ok() && in.left() == 0 && std::isfinite(out.rate_ppb) &&
         std::isfinite(out.noise_ns);
}

bool decode(const Header& header, const uint8_t* payload, FusedPose& out) {
  Reader in(payload, header.size);
  out.t = in.get<TimeNs>();
  in.get_doubles(out.T_EB.p);
  out.place.latitude_rad = in.get<double>();
  out.place.longitude_rad = in.get<double>();
  out.place.height_m = in.get<double>();
  Vec4 q_xyzw;
  in.get_doubles(q_xyzw);
  in.get_floats(out.v_EB);
  Mat6 cov;
  Mat3 cov_v;
  in.get_symmetric(cov);
  in.get_symmetric(cov_v);
  out.cov.setZero();
  out.cov.topLeftCorner<6, 6>() = cov;
  out.cov.bottomRightCorner<3, 3>() = cov_v;
  out.confidence = in.get<float>();
  out.resets = in.get<uint32_t>();
  const auto health = in.get<uint8_t>();
  out.health = static_cast<FusionHealth>(health);
  out.sources = in.get<uint8_t>();
  out.has_heading = in.get<uint8_t>() != 0;
  const bool good = header.kind == Kind::kFused && in.ok() && in.left() == 0 &&
                    health < static_cast<uint8_t>(FusionHealth::kCount) && out.T_EB.p.allFinite() &&
                    q_xyzw.allFinite() && std::fabs(q_xyzw.norm() - 1) < 1e-3;
  if (good) out.T_EB.R = rotation_from_quat_xyzw(q_xyzw.normalized());
  return good;
}

bool decode(const Header& header, const uint8_t* payload, ImuSample& out) {
  Reader in(payload, header.size);
  out.t = in.get<TimeNs>();
  in.get_doubles(out.w_B);
  in.get_doubles(out.f_B);
  return header.kind == Kind::kImu && in.ok() && in.left() == 0 && out.w_B.allFinite() &&
         out.f_B.allFinite();
}

bool decode(const Header& header, const uint8_t* payload, ClockMessage& out) {
  Reader in(payload, header.size);
  out.t_host = in.get<TimeNs>();
  out.t_device = in.get<TimeNs>();
  const bool clock = header.kind == Kind::kClock || header.kind == Kind::kAskClock;
  return clock && in.ok() && in.left() == 0;
}

bool decode(const Header& header, const uint8_t* payload, SubscribeMessage& out) {
  Reader in(payload, header.size);
  out.kinds = in.get<uint32_t>();
  out.lease_s = in.get<uint16_t>();
  return header.kind == Kind::kSubscribe && in.ok() && in.left() == 0;
}

}  // namespace pirvs::stream
