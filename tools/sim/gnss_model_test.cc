#include "tools/sim/gnss_model.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "core/math/geodesy.h"
#include "core/math/trig.h"
#include "tools/dataset/gnss_file.h"
#include "tools/dataset/recording.h"

namespace pirvs::tools {
namespace {

constexpr double kDegree = kPi / 180;

// Three times around a circle of 10 m, a minute each.
Trajectory circle() {
  Trajectory out;
  for (int i = 0; i <= 180 * 20; ++i) {
    TrajectoryPose pose;
    pose.t = 1'000'000'000 + i * TimeNs{50'000'000};
    const double angle = 2 * kPi * i / (60 * 20);
    pose.p_WB = Vec3(10 * std::cos(angle), 10 * std::sin(angle), 0);
    out.poses.push_back(pose);
  }
  return out;
}

// The error of each fix, by the azimuth of its true place.
struct Error {
  double azimuth_deg;
  Vec3 e_E;
};
std::vector<Error> errors_of(const GnssOptions& options) {
  const std::string folder =
      (std::filesystem::temp_directory_path() / ("pirvs_sector_" + std::to_string(getpid())))
          .string();
  const Trajectory truth = circle();
  write_gnss(options, truth, 1, folder);
  InputLog log;
  const auto fixes = read_gnss(folder + "/data.csv", GnssFormat::kTable, log);
  std::filesystem::remove_all(folder);
  const LocalFrame frame(
      {options.latitude_deg * kDegree, options.longitude_deg * kDegree, options.height_m});
  std::vector<Error> out;
  for (const GnssFix& fix : fixes) {
    const double t_s = to_seconds(fix.t - truth.poses[0].t);
    const double azimuth =
        std::remainder(2 * kPi * t_s / 60 + options.heading_deg * kDegree, 2 * kPi);
    const Vec3 p_E(10 * std::cos(azimuth), 10 * std::sin(azimuth), 0);
    out.push_back({azimuth / kDegree, frame.to_local({fix.latitude_deg * kDegree,
                                                      fix.longitude_deg * kDegree, fix.height_m}) -
                                          p_E});
  }
  return out;
}

TEST(gnss_model, multipath_of_a_sector_is_where_the_sector_is) {
  GnssOptions options;
  options.kind = "rtk";
  options.sigma_m = 1e-4;
  options.multipath_m = 4;
  options.multipath_sector = {150, 210};  // in the west, across the turn of angles
  int inside = 0;
  double largest_m = 0;
  for (const Error& error : errors_of(options)) {
    const double off_deg = std::remainder(error.azimuth_deg - 180, 360);
    if (std::abs(off_deg) > 31) {
      EXPECT_LT(error.e_E.norm(), 0.01) << error.azimuth_deg;
      continue;
    }
    ++inside;
    largest_m = std::max(largest_m, error.e_E.norm());
    const double expected_m = std::abs(off_deg) < 30 ? 2 * (1 + std::cos(off_deg / 30 * kPi)) : 0;
    EXPECT_NEAR(error.e_E.norm(), expected_m, 0.02) << "the same on each round";
    if (expected_m > 1) {
      EXPECT_LT(error.e_E.x(), 0) << "away from the middle";
      EXPECT_GT(error.e_E.z(), 0);
    }
  }
  EXPECT_NEAR(inside, 3 * 5 * 10, 6) << "a sixth of three minutes at 5 Hz";
  EXPECT_NEAR(largest_m, 4, 0.02);
}

}  // namespace
}  // namespace pirvs::tools
