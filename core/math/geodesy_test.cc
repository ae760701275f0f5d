#include "core/math/geodesy.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/trig.h"

namespace pirvs {
namespace {

constexpr double kDeg = kPi / 180;

// Points that define the ellipsoid.
TEST(geodesy, known_places) {
  EXPECT_LT((to_ecef({0, 0, 0}) - Vec3(6378137, 0, 0)).norm(), 1e-9);
  EXPECT_LT((to_ecef({0, 90 * kDeg, 100}) - Vec3(0, 6378237, 0)).norm(), 1e-6);
  EXPECT_LT((to_ecef({90 * kDeg, 0, 0}) - Vec3(0, 0, 6356752.314245)).norm(), 1e-5);
  const Geodetic pole = to_geodetic(Vec3(0, 0, -6356752.314245 - 50));
  EXPECT_NEAR(pole.latitude_rad, -90 * kDeg, 1e-12);
  EXPECT_NEAR(pole.height_m, 50, 1e-6);
}

TEST(geodesy, geodetic_undoes_ecef) {
  for (double lat = -90; lat <= 90; lat += 7.5) {
    for (double lon = -179; lon <= 180; lon += 23.7) {
      for (const double height : {-1e4, 0.0, 1600.0, 4e5, 2e7, 1e8}) {
        const Geodetic place = {lat * kDeg, lon * kDeg, height};
        const Geodetic back = to_geodetic(to_ecef(place));
        EXPECT_LT((to_ecef(back) - to_ecef(place)).norm(), 1e-6) << lat << " " << lon;
        EXPECT_NEAR(back.height_m, height, 1e-6) << lat << " " << height;
        EXPECT_NEAR(back.latitude_rad, place.latitude_rad, 1e-12);
      }
    }
  }
}

// A step of latitude, longitude and height is a step north, east and up: against the radii of
// curvature, which the code does not have.
TEST(geodesy, local_axes_are_east_north_up) {
  const Geodetic origin = {40.1 * kDeg, -105.1 * kDeg, 1600};
  const LocalFrame frame(origin);
  const double sin2 = std::pow(std::sin(origin.latitude_rad), 2);
  const double e2 = kEarthFlattening * (2 - kEarthFlattening);
  const double N = kEarthRadius_m / std::sqrt(1 - e2 * sin2);
  const double M = kEarthRadius_m * (1 - e2) / std::pow(1 - e2 * sin2, 1.5);
  const double step = 1e-6;
  Geodetic north = origin, east = origin, up = origin;
  north.latitude_rad += step;
  east.longitude_rad += step;
  up.height_m += 5;
  EXPECT_LT((frame.to_local(north) - Vec3(0, step * (M + 1600), 0)).norm(), 1e-4);
  EXPECT_LT(
      (frame.to_local(east) - Vec3(step * (N + 1600) * std::cos(origin.latitude_rad), 0, 0)).norm(),
      1e-4);
  EXPECT_LT((frame.to_local(up) - Vec3(0, 0, 5)).norm(), 1e-8);
}

TEST(geodesy, local_and_global_undo_each_other) {
  const LocalFrame frame({-33.9 * kDeg, 151.2 * kDeg, 20});
  for (const Vec3& p_E : {Vec3(0, 0, 0), Vec3(1, -2, 3), Vec3(5000, 8000, -100)}) {
    EXPECT_LT((frame.to_local(frame.to_global(p_E)) - p_E).norm(), 1e-6);
  }
}

TEST(geodesy, turn_from_another_place_takes_its_axes_here) {
  const LocalFrame frame({50 * kDeg, 8 * kDeg, 0});
  const Geodetic there = frame.to_global(Vec3(20000, 30000, 0));
  Geodetic north = there, up = there;
  north.latitude_rad += 1e-6;
  up.height_m += 6;
  const Mat3 R = frame.turn_from(there);
  const Vec3 step = frame.to_local(north) - frame.to_local(there);
  EXPECT_LT((R.col(1) - step.normalized()).norm(), 1e-5);
  EXPECT_LT((R.col(2) - (frame.to_local(up) - frame.to_local(there)) / 6).norm(), 1e-8);
}

}  // namespace
}  // namespace pirvs
