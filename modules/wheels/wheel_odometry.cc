#include "modules/wheels/wheel_odometry.h"

#include <algorithm>
#include <cmath>

#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr double kSpeed_m_s_max = 60, kTurn_rad_s_max = 20;
constexpr double kSteering_rad_max = 1.4;
constexpr TimeNs kGap_ns = 500'000'000;  // a longer one is no interval to take a mean of

double together(double a, double b) { return std::sqrt(a * a + b * b); }

}  // namespace

void WheelOdometry::configure(const WheelCalibration& calibration, const WheelParams& params) {
  calibration_ = calibration;
  params_ = params;
}

Status WheelOdometry::take(const WheelSample& sample, WheelVelocity& out) {
  if (!calibration_.known || !std::isfinite(sample.value[0]) || !std::isfinite(sample.value[1])) {
    return Status::kBadData;
  }
  const bool follows = has_last_ && last_.kind == sample.kind;
  if (follows && sample.t <= last_.t) return Status::kStale;
  const TimeNs dt_ns = follows ? sample.t - last_.t : 0;
  out = WheelVelocity{};
  out.t = sample.t + calibration_.time_offset_ns;
  out.dt_ns = dt_ns;
  const Status status = measure(sample, to_seconds(dt_ns), out);
  last_ = sample;
  has_last_ = true;
  if (status != Status::kOk) return status;
  out.forward_m_s *= scale_;
  if (sample.kind != WheelKind::kTwist) out.turn_rad_s *= scale_;
  if (std::fabs(out.forward_m_s) > kSpeed_m_s_max || std::fabs(out.turn_rad_s) > kTurn_rad_s_max) {
    return Status::kBadData;
  }
  const double speed = std::fabs(out.forward_m_s), turn = std::fabs(out.turn_rad_s);
  out.sigma_m_s = together(out.sigma_m_s, params_.sigma_m_s + params_.sigma_share * speed);
  out.side_sigma_m_s = params_.side_m_s + params_.side_share * speed;
  out.turn_sigma_rad_s =
      together(out.turn_sigma_rad_s, params_.turn_rad_s + params_.turn_share * turn);
  return Status::kOk;
}

Status WheelOdometry::measure(const WheelSample& sample, double dt_s, WheelVelocity& out) const {
  const double a = sample.value[0], b = sample.value[1];
  const auto left_right = [&](double left, double right, double scale, double sigma) {
    out.forward_m_s = scale * (left + right) / 2;
    out.sigma_m_s = sigma;
    out.has_turn = calibration_.track_m > 0;
    if (!out.has_turn) return;
    out.turn_rad_s = scale * (right - left) / calibration_.track_m;
    out.turn_sigma_rad_s = 2 * sigma / calibration_.track_m;
  };
  switch (sample.kind) {
    case WheelKind::kLeftRight:
      left_right(a, b, 1, 0);
      return Status::kOk;
    case WheelKind::kTwist:
      out.forward_m_s = a;
      out.turn_rad_s = b;
      out.has_turn = true;
      return Status::kOk;
    case WheelKind::kSteering: {
      if (!(calibration_.wheelbase_m > 0) || std::fabs(b) > kSteering_rad_max) {
        return Status::kBadData;
      }
      out.forward_m_s = a;
      out.turn_rad_s = a * sine(b) / cosine(b) / calibration_.wheelbase_m;
      out.has_turn = true;
      return Status::kOk;
    }
    case WheelKind::kTicks: {
      if (!(calibration_.tick_m > 0)) return Status::kBadData;
      if (dt_s <= 0 || out.dt_ns > kGap_ns) return Status::kEmpty;
      // The mean between two readings, each of which is a count at most too low.
      constexpr double kUniform = 0.41;  // sigma of the difference of two, in counts
      const double m_s = calibration_.tick_m / dt_s;
      left_right(a - last_.value[0], b - last_.value[1], m_s, kUniform * m_s);
      out.t -= out.dt_ns / 2;
      return Status::kOk;
    }
  }
  return Status::kBadData;
}

}  // namespace pirvs
