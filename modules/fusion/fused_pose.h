// What fusion gives out: the pose of the body on the Earth, from SLAM and GNSS together.
// Frames  E: east, north, up, about the first good fix. B: IMU. W: SLAM's world.
// Units   m, rad, m/s; ns on the IMU's clock.
// Errors  none.
// Source  docs/conventions.md, "GNSS"; docs/adr/0017-fusion-anchors-slam.md.
#pragma once

#include "core/base/time.h"
#include "core/math/geodesy.h"
#include "core/math/se3.h"

namespace pirvs {

enum class FusionHealth : uint8_t {
  kNone,           // no good fix yet: there is no place to tell
  kAligning,       // GNSS carries the position; SLAM's heading on the Earth is still unknown
  kFused,          // both
  kSlamOnly,       // GNSS is out: SLAM carries on from where it was anchored
  kGnssOnly,       // SLAM is lost: GNSS carries the position
  kDeadReckoning,  // both are gone: the last velocity, and a covariance that grows
  kCount
};
const char* name(FusionHealth health);

inline constexpr uint8_t kFromSlam = 1, kFromGnss = 2;  // FusedPose::sources, bits

struct FusedPose {
  TimeNs t = 0;
  SE3 T_EB;
  Vec3 v_EB = Vec3::Zero();
  Mat9 cov = Mat9::Zero();  // theta (in B), p, v (in E)
  Geodetic place;           // of B
  FusionHealth health = FusionHealth::kNone;
  uint8_t sources = 0;
  bool has_heading = false;  // else the yaw of T_EB is SLAM's own, and says nothing
  float confidence = 0;      // 0: do not use, 1: as good as it gets
  uint32_t resets = 0;       // changes whenever the pose may have jumped
};

}  // namespace pirvs
