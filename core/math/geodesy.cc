#include "core/math/geodesy.h"

#include <cmath>

#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr double kA = kEarthRadius_m;
constexpr double kB = kA * (1 - kEarthFlattening);
constexpr double kE2 = kEarthFlattening * (2 - kEarthFlattening);  // first eccentricity squared
constexpr double kSecond2 = kE2 / (1 - kE2);                       // second eccentricity squared

// Radius of curvature in the prime vertical.
double normal_radius(double sin_latitude) {
  return kA / std::sqrt(1 - kE2 * sin_latitude * sin_latitude);
}

Mat3 axes_at(const Geodetic& place) {
  double sin_lat, cos_lat, sin_lon, cos_lon;
  sincos(place.latitude_rad, sin_lat, cos_lat);
  sincos(place.longitude_rad, sin_lon, cos_lon);
  Mat3 R_ecef_E;
  R_ecef_E << -sin_lon, -sin_lat * cos_lon, cos_lat * cos_lon,  //
      cos_lon, -sin_lat * sin_lon, cos_lat * sin_lon,           //
      0, cos_lat, sin_lat;
  return R_ecef_E;
}

}  // namespace

Vec3 to_ecef(const Geodetic& place) {
  double sin_lat, cos_lat, sin_lon, cos_lon;
  sincos(place.latitude_rad, sin_lat, cos_lat);
  sincos(place.longitude_rad, sin_lon, cos_lon);
  const double N = normal_radius(sin_lat);
  const double across = (N + place.height_m) * cos_lat;
  return {across * cos_lon, across * sin_lon, (N * (1 - kE2) + place.height_m) * sin_lat};
}

Geodetic to_geodetic(const Vec3& p_ecef) {
  const double across = std::sqrt(p_ecef.x() * p_ecef.x() + p_ecef.y() * p_ecef.y());
  const double z = p_ecef.z();
  Geodetic out;
  out.longitude_rad = arctan2(p_ecef.y(), p_ecef.x());
  // The reduced latitude beta as sine and cosine; it gives the latitude, and that a better beta.
  double sin_beta = z * kA, cos_beta = across * kB;
  double sin_lat = 0, cos_lat = 1;
  for (int i = 0; i < 3; ++i) {
    const double beta = std::sqrt(sin_beta * sin_beta + cos_beta * cos_beta);
    if (!(beta > 0)) break;
    const double s = sin_beta / beta, c = cos_beta / beta;
    const double up = z + kSecond2 * kB * s * s * s, along = across - kE2 * kA * c * c * c;
    const double length = std::sqrt(up * up + along * along);
    if (!(length > 0)) break;
    sin_lat = up / length, cos_lat = along / length;
    sin_beta = kB * sin_lat, cos_beta = kA * cos_lat;
  }
  out.latitude_rad = arctan2(sin_lat, cos_lat);
  // Exact at the poles, where across / cos would not be.
  const double N = normal_radius(sin_lat);
  out.height_m = across * cos_lat + z * sin_lat - N * (1 - kE2 * sin_lat * sin_lat);
  return out;
}

LocalFrame::LocalFrame(const Geodetic& origin)
    : origin_(origin), p_ecef_(to_ecef(origin)), R_ecef_E_(axes_at(origin)) {}

Vec3 LocalFrame::to_local(const Geodetic& place) const {
  return R_ecef_E_.transpose() * (to_ecef(place) - p_ecef_);
}

Geodetic LocalFrame::to_global(const Vec3& p_E) const {
  return to_geodetic(p_ecef_ + R_ecef_E_ * p_E);
}

Mat3 LocalFrame::turn_from(const Geodetic& place) const {
  return R_ecef_E_.transpose() * axes_at(place);
}

}  // namespace pirvs
