#include "modules/tracking/turn_check.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "core/math/so3.h"
#include "core/math/square.h"

namespace pirvs {
namespace {

constexpr int kTracksMax_fit = 40, kTracksMin = 12;
constexpr double kMemory = 2, kEnough = 0.02;  // of an axis, (rad/s)^2
constexpr double kStray_rad = 0.02;

}  // namespace

void TurnCheck::add(const Camera& camera, const Tracks& tracks, const Vec3& turn_B, double dt_s) {
  Vec3 seen_B;
  const bool had_last = has_last_;
  has_last_ = dt_s > 0 && turn_of_image(camera, tracks, seen_B);
  if (!has_last_) return;
  const Rates before = last_;
  last_ = {seen_B / dt_s, turn_B / dt_s};
  if (!had_last) return;
  const Vec3 image_B = last_.image_B - before.image_B, gyro_B = last_.gyro_B - before.gyro_B;
  const double kept = kMemory / (kMemory + gyro_B.squaredNorm());
  cross_ = kept * cross_ + image_B * gyro_B.transpose();
  gyro_ = kept * gyro_ + gyro_B * gyro_B.transpose();
}

// The rotation that explains the flow best, as if nothing had moved; twice, the second time with
// less of what does not fit the first.
bool TurnCheck::turn_of_image(const Camera& camera, const Tracks& tracks, Vec3& turn_B) const {
  const size_t stride = std::max<size_t>(1, tracks.size() / kTracksMax_fit);
  Vec3 turn_C = Vec3::Zero();
  for (int pass = 0; pass < 2; ++pass) {
    Mat3 H = 1e-6 * Mat3::Identity();
    Vec3 g = Vec3::Zero();
    int count = 0;
    for (size_t i = 0; i < tracks.size(); i += stride) {
      const Track& track = tracks[i];
      Vec3 before, now;
      if (track.age == 0 || !camera.unproject(Vec2(track.x_last, track.y_last), before) ||
          !camera.unproject(Vec2(track.x, track.y), now)) {
        continue;
      }
      // A point that stands: now = before - turn x before.
      const Mat3 J = skew(before);
      const Vec3 r = now - before - J * turn_C;
      const double weight = pass == 0 ? 1 : 1 / (1 + r.squaredNorm() / square(kStray_rad));
      H += weight * J.transpose() * J;
      g += weight * J.transpose() * r;
      ++count;
    }
    if (count < kTracksMin) return false;
    turn_C += H.inverse() * g;
  }
  turn_B = camera.T_BC.R * turn_C;
  return turn_B.allFinite();
}

Mat3 TurnCheck::gain() const { return cross_ * (gyro_ + kEnough * Mat3::Identity()).inverse(); }

bool TurnCheck::against() const {
  constexpr double kOther = -0.4, kExchanged = 0.5, kLittle = 0.3;
  const Mat3 K = gain();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const bool exchanged = std::abs(K(i, j)) > kExchanged && std::abs(K(j, i)) > kExchanged;
    if (K(i, i) < kOther || (exchanged && std::max(K(i, i), K(j, j)) < kLittle)) return true;
  }
  return false;
}

}  // namespace pirvs
