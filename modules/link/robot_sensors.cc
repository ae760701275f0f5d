#include "modules/link/robot_sensors.h"

#include <cmath>

namespace pirvs {
namespace {

constexpr double kMilli = 1e-3, kTenMillionth = 1e-7;
constexpr uint16_t kUnknown = UINT16_MAX;

// GPS_FIX_TYPE; what is none, or none that we know, is none.
GnssFixType fix_type_of(uint8_t type) {
  switch (type) {
    case 2:
      return GnssFixType::k2d;
    case 3:  // 3D
    case 4:  // with differential corrections
    case 8:  // by precise point positioning
      return GnssFixType::k3d;
    case 5:
      return GnssFixType::kFloat;
    case 6:
      return GnssFixType::kFixed;
    default:
      return GnssFixType::kNone;
  }
}

// False for what is not finite, too.
bool within(double value, double low, double high) { return value >= low && value <= high; }

bool can_be(const GnssFix& fix) {
  constexpr double kHeightMax_m = 1e5, kSigmaMax_m = 1e4, kSpeedMax_m_s = 1e3;
  return within(fix.latitude_deg, -90, 90) && within(fix.longitude_deg, -180, 180) &&
         within(fix.height_m, -kHeightMax_m, kHeightMax_m) &&
         within(fix.sigma_horizontal_m, 1e-4, kSigmaMax_m) &&
         within(fix.sigma_vertical_m, 1e-4, kSigmaMax_m) &&
         within(fix.sigma_velocity_m_s, 0, kSpeedMax_m_s) &&
         within(fix.v_ned.norm(), 0, kSpeedMax_m_s);
}

}  // namespace

TimeNs RobotSensors::time_of(TimeNs now, const PeerClock& clock, uint64_t time_usec) {
  constexpr uint64_t kTimeMax_usec = INT64_MAX / 4 / 1000;
  if (time_usec == 0 || time_usec > kTimeMax_usec) return now;
  const Result<TimeNs> t = clock.ours(static_cast<TimeNs>(time_usec) * 1000);
  const bool believable = t.ok() && t.value() <= now && t.value() >= now - kAgeMax_ns;
  return believable ? t.value() : now;
}

Status RobotSensors::finish(TimeNs now, const PeerClock& clock, uint64_t time_usec,
                            uint8_t fix_type, GnssFix& fix) {
  fix.type = fix_type_of(fix_type);
  if (fix.type == GnssFixType::kNone) return Status::kEmpty;
  if (!can_be(fix)) return Status::kBadData;
  fix.t = time_of(now, clock, time_usec);
  if (fix.t <= fix_t_ || now - fix_came_t_ < kPeriodMin_ns) return Status::kStale;
  fix_t_ = fix.t;
  fix_came_t_ = now;
  return Status::kOk;
}

Status RobotSensors::take(TimeNs now, const PeerClock& clock, const mavlink::GpsRawInt& message,
                          GnssFix& out) {
  // A receiver that does not say how good it is has a range error of this size (u-blox, M8).
  constexpr double kRangeSigma_m = 2.5;
  constexpr double kDilution = 1e-2 * kRangeSigma_m;
  out = GnssFix{};
  out.latitude_deg = kTenMillionth * message.lat_1e7_deg;
  out.longitude_deg = kTenMillionth * message.lon_1e7_deg;
  const bool ellipsoid = message.alt_ellipsoid_mm != 0;
  out.height_m = kMilli * (ellipsoid ? message.alt_ellipsoid_mm : message.alt_mm);
  out.sigma_horizontal_m = kMilli * message.h_acc_mm;
  out.sigma_vertical_m = kMilli * message.v_acc_mm;
  if (message.h_acc_mm == 0 && message.eph != kUnknown) {
    out.sigma_horizontal_m = kDilution * message.eph;
  }
  if (message.v_acc_mm == 0 && message.epv != kUnknown) {
    out.sigma_vertical_m = kDilution * message.epv;
  }
  return finish(now, clock, message.time_usec, message.fix_type, out);
}

Status RobotSensors::take(TimeNs now, const PeerClock& clock, const mavlink::GpsInput& message,
                          GnssFix& out) {
  using mavlink::GpsInput;
  if ((message.ignore_flags & (GpsInput::kNoAltitude | GpsInput::kNoSigmas)) != 0) {
    return Status::kBadData;
  }
  out = GnssFix{};
  out.latitude_deg = kTenMillionth * message.lat_1e7_deg;
  out.longitude_deg = kTenMillionth * message.lon_1e7_deg;
  out.height_m = static_cast<double>(message.alt_m);
  out.sigma_horizontal_m = static_cast<double>(message.horiz_accuracy_m);
  out.sigma_vertical_m = static_cast<double>(message.vert_accuracy_m);
  if ((message.ignore_flags & (GpsInput::kNoSpeed | GpsInput::kNoSpeedSigma)) == 0) {
    for (int i = 0; i < 3; ++i) out.v_ned(i) = static_cast<double>(message.v_ned_m_s[i]);
    out.sigma_velocity_m_s = static_cast<double>(message.speed_accuracy_m_s);
    out.has_velocity = out.sigma_velocity_m_s > 0;
  }
  return finish(now, clock, message.time_usec, message.fix_type, out);
}

Status RobotSensors::take(TimeNs now, const PeerClock& clock, const mavlink::WheelDistance& message,
                          WheelSample& out) {
  constexpr double kSpeedMax_m_s = 100;
  constexpr uint64_t kGapMax_usec = 1'000'000;
  if (message.count < 2 || message.count > mavlink::WheelDistance::kWheelsMax ||
      !std::isfinite(message.distance_m[0]) || !std::isfinite(message.distance_m[1])) {
    return Status::kBadData;
  }
  const bool stale = has_wheels_ && message.time_usec == wheels_.time_usec;
  if (stale || now - wheel_came_t_ < kPeriodMin_ns) return Status::kStale;
  const mavlink::WheelDistance before = wheels_;
  const bool has_before = has_wheels_;
  wheels_ = message;
  has_wheels_ = true;
  wheel_came_t_ = now;
  const uint64_t gap_usec = message.time_usec - before.time_usec;  // huge, if it runs back
  if (!has_before || gap_usec > kGapMax_usec) return Status::kEmpty;
  const auto half_ns = static_cast<TimeNs>(gap_usec) * 500;
  out = WheelSample{};
  out.t = time_of(now, clock, message.time_usec) - half_ns;
  out.kind = WheelKind::kLeftRight;
  for (int i = 0; i < 2; ++i) {
    out.value[i] =
        (message.distance_m[i] - before.distance_m[i]) / (1e-6 * static_cast<double>(gap_usec));
    if (!within(out.value[i], -kSpeedMax_m_s, kSpeedMax_m_s)) return Status::kBadData;
  }
  return Status::kOk;
}

}  // namespace pirvs
