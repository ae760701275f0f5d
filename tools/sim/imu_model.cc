#include "tools/sim/imu_model.h"

#include <cmath>

#include "modules/imu/gravity.h"
#include "tools/sim/random.h"

namespace pirvs::tools {
namespace {

Vec3 normal(Random& random, double sigma) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return sigma * Vec3(x, y, z);
}

}  // namespace

std::vector<SimulatedImu> simulate_imu(const Path& path, const ImuModel& model, TimeNs begin,
                                       uint64_t seed) {
  Random random(seed, 2);
  const double rate_hz = model.noise.rate_hz;
  const double root_rate = std::sqrt(rate_hz);
  const size_t count = size_t(std::floor(path.duration_s() * rate_hz + 1e-9)) + 1;
  std::vector<SimulatedImu> out(count);
  Vec3 b_g = normal(random, model.gyro_bias_rad_s);
  Vec3 b_a = normal(random, model.accel_bias_m_s2);
  for (size_t k = 0; k < count; ++k) {
    SimulatedImu& imu = out[k];
    imu.sample.t = begin + from_seconds(double(k) / rate_hz);
    imu.truth = path.at(double(k) / rate_hz);
    imu.b_g = b_g;
    imu.b_a = b_a;
    const Vec3 f_W = imu.truth.a_WB + Vec3(0, 0, kGravity_m_s2);
    imu.sample.w_B = imu.truth.w_B + b_g + normal(random, model.noise.gyro_noise * root_rate);
    imu.sample.f_B = imu.truth.R_WB.transpose() * f_W + b_a +
                     normal(random, model.noise.accel_noise * root_rate);
    b_g += normal(random, model.noise.gyro_walk / root_rate);
    b_a += normal(random, model.noise.accel_walk / root_rate);
  }
  return out;
}

}  // namespace pirvs::tools
