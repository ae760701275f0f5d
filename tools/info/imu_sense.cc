#include "tools/info/imu_sense.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace pirvs::tools {
namespace {

constexpr double kDegrees = 180 / M_PI;

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

// Over tenths of a second: motors shake harder than gravity pulls.
constexpr TimeNs kWindow = 100'000'000;
struct Mean {
  Vec3 w = Vec3::Zero(), f = Vec3::Zero();
  double t_s = 0;
};
std::vector<Mean> means_of(const std::vector<ImuSample>& samples) {
  std::vector<Mean> means;
  for (size_t i = 0; i < samples.size();) {
    Mean mean;
    size_t n = 0;
    const TimeNs begin = samples[i].t;
    for (; i < samples.size() && samples[i].t < begin + kWindow; ++i, ++n) {
      mean.w += samples[i].w_B;
      mean.f += samples[i].f_B;
      mean.t_s += to_seconds(samples[i].t - samples[0].t);
    }
    mean.w /= double(n);
    mean.f /= double(n);
    mean.t_s /= double(n);
    means.push_back(mean);
  }
  return means;
}

// By how much the measured rate must be multiplied to turn the force as it was measured to turn; 0:
// the body did not tilt.
double rate_scale(const std::vector<Mean>& means) {
  double with = 0, of = 0;
  for (size_t i = 1; i < means.size(); ++i) {
    const double dt = means[i].t_s - means[i - 1].t_s;
    if (dt > 3 * to_seconds(kWindow)) continue;
    const Vec3 w = (means[i].w + means[i - 1].w) / 2, f = (means[i].f + means[i - 1].f) / 2;
    const Vec3 turn = -w.cross(f) * dt;
    with += turn.dot(means[i].f - means[i - 1].f);
    of += turn.squaredNorm();
  }
  return of > 0 ? with / of : 0;
}

ImuFault find_force_fault(double force, double rate) {
  const std::string is =
      "the accelerometer's size is " + number(force) + " in the median, not 9.81";
  const auto about = [&](double value) { return force > 0.75 * value && force < 1.33 * value; };
  if (rate > 7 && rate < 13 && force < 5) {
    return {"the gyro's size is " + number(rate) + ", the accelerometer's " + number(force) +
                ": the columns are exchanged",
            "write w_x,w_y,w_z,a_x,a_y,a_z, or name the columns so in the heading"};
  }
  if (about(1)) return {is, "give m/s^2, not g: multiply by 9.80665"};
  if (about(1000) || about(9806.65)) {
    return {is, "give m/s^2, not mg or mm/s^2"};
  }
  if (force < 5) {
    return {is + ": gravity is missing",
            "give the raw accelerometer, not the linear acceleration without gravity"};
  }
  return {is, "give m/s^2"};
}

}  // namespace

ImuFault find_imu_fault(const std::vector<ImuSample>& samples) {
  constexpr double kForce_min = 5, kForce_max = 20;  // of what flies, drives or is carried
  constexpr size_t kSamplesMin = 100;
  constexpr double kZeros_max = 0.05;
  if (samples.size() < kSamplesMin) return {};
  const std::vector<Mean> means = means_of(samples);
  std::vector<double> forces, rates;
  for (const Mean& mean : means) forces.push_back(mean.f.norm());
  double rate2 = 0;
  size_t no_force = 0, no_rate = 0;
  for (const ImuSample& sample : samples) {
    no_force += sample.f_B.isZero(0);
    no_rate += sample.w_B.isZero(0);
    rates.push_back(sample.w_B.norm());
    rate2 += sample.w_B.squaredNorm();
  }
  const auto of_all = [&](size_t n) {
    return std::to_string(n) + " of " + std::to_string(samples.size());
  };
  if (double(no_force) > kZeros_max * double(samples.size()) && no_force < samples.size()) {
    return {of_all(no_force) + " IMU samples have an acceleration of exactly 0",
            "write one row for both sensors, the slower one interpolated (RealSense: "
            "unite_imu_method 2)"};
  }
  const double force = median(forces), rate = median(rates);
  if (!(force > kForce_min && force < kForce_max)) return find_force_fault(force, rate);
  if (no_rate == samples.size()) return {};  // a simulated one at rest
  std::sort(rates.begin(), rates.end());
  constexpr double kFast_rad_s = 2, kNever_rad_s = 8;  // the latter of all, root mean square
  constexpr double kScaleNever = 0.1;                  // accelerations hide how the force turns
  const double scale = rate_scale(means), rms = std::sqrt(rate2 / double(samples.size()));
  const bool tenth = rates[rates.size() * 9 / 10] > kFast_rad_s;
  const bool degrees = scale > 0.4 / kDegrees && scale < 2.5 / kDegrees;
  if ((tenth && degrees) || (rms > kNever_rad_s && std::abs(scale) < kScaleNever)) {
    return {degrees ? "the force turns " + number(1 / scale) + " times slower than the gyro says"
                    : "the gyro says " + number(rms) + " rad/s, root mean square",
            "give rad/s, not deg/s: divide by 57.29578"};
  }
  return {};
}

}  // namespace pirvs::tools
