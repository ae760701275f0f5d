// Pins the bits of trig, so3 and camera: the same on x86-64 and AArch64, at every optimization.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>

#include "core/camera/camera.h"
#include "core/math/so3.h"
#include "core/math/trig.h"

namespace pirvs {
namespace {

// FNV-1a over the bytes of what is added.
class Hash {
 public:
  template <class T>
  void add(const T& value) {
    uint8_t bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    for (const uint8_t byte : bytes) hash_ = (hash_ ^ byte) * 1099511628211ull;
  }
  uint64_t value() const { return hash_; }

 private:
  uint64_t hash_ = 14695981039346656037ull;
};

class Random {
 public:
  double next() {  // [-2, 2)
    state_ = state_ * 1664525u + 1013904223u;
    return static_cast<int32_t>(state_) / static_cast<double>(1u << 30);
  }
  Vec3 next_vec3() {
    Vec3 v;
    for (int i = 0; i < 3; ++i) v[i] = next();  // arguments of a call have no defined order
    return v;
  }

 private:
  uint32_t state_ = 7;
};

TEST(BitParity, Trig) {
  Random random;
  Hash hash;
  for (int i = 0; i < 5000; ++i) {
    const double x = 10.0 * random.next(), y = random.next();
    double s, c;
    sincos(x, s, c);
    for (const double value :
         {s, c, arctan2(y, x), arccos(0.5 * y), exponential(x), logarithm(x * x + 1e-3)}) {
      hash.add(value);
    }
  }
  EXPECT_EQ(hash.value(), 0x8947d0d73f63bd0eu);
}

TEST(BitParity, So3) {
  Random random;
  Hash hash;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 phi = (i % 3 == 0 ? 0.01 : 1.0) * random.next_vec3();
    const Mat3 R = so3_exp(phi);
    hash.add(R);
    hash.add(so3_log(R));
    hash.add(right_jacobian(phi));
    hash.add(right_jacobian_inverse(phi));
    hash.add(orthonormalized(R));
  }
  EXPECT_EQ(hash.value(), 0x721b63e9ae21bf00u);
}

uint64_t hash_of(CameraModel model, double k1, double k2, double k3, double k4) {
  const Camera camera{model, 752, 480, 458.0, 457.0, 367.0, 248.0, {k1, k2, k3, k4}, SE3{}};
  Random random;
  Hash hash;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p_C = random.next_vec3() + Vec3::UnitZ();
    Vec2 uv;
    Mat23 J;
    Vec3 bearing_C;
    if (!camera.project(p_C, uv, J) || !camera.unproject(uv, bearing_C)) continue;
    hash.add(uv);
    hash.add(J);
    hash.add(bearing_C);
  }
  return hash.value();
}

TEST(BitParity, Camera) {
  EXPECT_EQ(hash_of(CameraModel::kPinholeRadtan, -0.283, 0.074, 1.9e-4, 1.8e-5),
            0x7b4141a844763620u);
  EXPECT_EQ(hash_of(CameraModel::kKannalaBrandt, 3.5e-3, 7.2e-4, -2.1e-3, 2e-4),
            0x2f229b2a0b2e15dbu);
}

}  // namespace
}  // namespace pirvs
