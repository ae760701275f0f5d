// Places on the Earth: latitude, longitude and height on the WGS 84 ellipsoid, Earth-centred
// Cartesian coordinates, and a local east-north-up frame.
// In      Radians and metres above the ellipsoid (not above the geoid).
// Out     to_ecef and to_geodetic undo each other to 1e-6 m, from 10 km below the ellipsoid to
//         100,000 km above it, at the poles too. Longitude in (-pi, pi].
// Frames  ECEF: x to longitude 0 on the equator, z to the north pole. E: x east, y north, z up,
//         tangent to the ellipsoid at its origin.
// Errors  none; what is not finite stays so. The centre of the Earth has no latitude: 0 is given.
// Cost    to_ecef ~30 ns, to_geodetic ~150 ns.
// Source  NIMA TR8350.2 (WGS 84); Bowring, Survey Review 1976, three iterations.
#pragma once

#include "core/math/types.h"

namespace pirvs {

struct Geodetic {
  double latitude_rad = 0, longitude_rad = 0, height_m = 0;
};

inline constexpr double kEarthRadius_m = 6378137.0;  // at the equator
inline constexpr double kEarthFlattening = 1 / 298.257223563;

Vec3 to_ecef(const Geodetic& place);
Geodetic to_geodetic(const Vec3& p_ecef);

// The east-north-up frame about a place.
class LocalFrame {
 public:
  LocalFrame() : LocalFrame(Geodetic{}) {}
  explicit LocalFrame(const Geodetic& origin);

  const Geodetic& origin() const { return origin_; }
  Vec3 to_local(const Geodetic& place) const;
  Geodetic to_global(const Vec3& p_E) const;
  // Takes coordinates of the east-north-up frame about `place` to those of this one: it turns by
  // 0.01 degrees a kilometre and more near the poles.
  Mat3 turn_from(const Geodetic& place) const;

 private:
  Geodetic origin_;
  Vec3 p_ecef_;
  Mat3 R_ecef_E_;
};

}  // namespace pirvs
