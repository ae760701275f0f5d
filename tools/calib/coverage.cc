#include "tools/calib/coverage.h"

#include <algorithm>
#include <cmath>

namespace pirvs::tools {
namespace {

constexpr double kDegrees = 180 / M_PI;
// Less than this leaves focal length, distance and the board's shape to each other.
constexpr double kTilt_deg_min = 15, kRoll_deg_min = 25, kNearToFarMin = 1.15;
constexpr int kRimTagsMin = 5;   // seen near each side of the image
constexpr double kRim = 0.1875;  // of the image's width or height: three columns, two rows

double quantile(std::vector<double>& values, double q) {
  const auto at = values.begin() + long(q * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

int column_sum(const Coverage& coverage, int camera, int from, int to) {
  int sum = 0;
  for (const auto& row : coverage.cells[camera]) {
    for (int x = from; x < to; ++x) sum += row[x];
  }
  return sum;
}

int row_sum(const Coverage& coverage, int camera, int from, int to) {
  int sum = 0;
  for (int y = from; y < to; ++y) {
    for (const int count : coverage.cells[camera][y]) sum += count;
  }
  return sum;
}

const char* bare_side(const Coverage& coverage, int camera) {
  constexpr int kW = Coverage::kColumns, kH = Coverage::kRows;
  const int wide = int(std::lround(kRim * kW)), high = int(std::lround(kRim * kH));
  if (column_sum(coverage, camera, 0, wide) < kRimTagsMin) return "left";
  if (column_sum(coverage, camera, kW - wide, kW) < kRimTagsMin) return "right";
  if (row_sum(coverage, camera, 0, high) < kRimTagsMin) return "upper";
  if (row_sum(coverage, camera, kH - high, kH) < kRimTagsMin) return "lower";
  return nullptr;
}

}  // namespace

Coverage measure(const Target& target, const CameraRig& rig, const std::vector<PosedShot>& shots) {
  Coverage out;
  std::vector<double> tilt, roll, far;
  for (const PosedShot& shot : shots) {
    for (int c = 0; c < rig.cameras; ++c) {
      const Camera& camera = rig.camera[c];
      for (const SeenTag& tag : shot.shot.view[c].tags) {
        const int x = int((tag.uv.x() + 0.5) / camera.width * Coverage::kColumns);
        const int y = int((tag.uv.y() + 0.5) / camera.height * Coverage::kRows);
        ++out.cells[c][std::clamp(y, 0, Coverage::kRows - 1)]
                   [std::clamp(x, 0, Coverage::kColumns - 1)];
      }
    }
    const SE3& T = shot.T_C0T;
    const Vec3 middle = T * target.middle_T();
    far.push_back(middle.norm());
    const double facing = std::abs(T.R.col(2).dot(middle)) / middle.norm();
    tilt.push_back(kDegrees * std::acos(std::min(1.0, facing)));
    roll.push_back(kDegrees * std::atan2(T.R(1, 0), T.R(0, 0)));
  }
  if (shots.empty()) return out;
  out.tilt_deg = quantile(tilt, 0.9);
  // About the first shot's, so that a board hung upside down is no turn of 360 degrees.
  const double first = roll.front();
  for (double& angle : roll) angle = std::remainder(angle - first, 360.0);
  out.roll_deg = quantile(roll, 0.95) - quantile(roll, 0.05);
  out.near_to_far = quantile(far, 0.95) / quantile(far, 0.05);
  return out;
}

Lack missing(const Coverage& coverage, int cameras) {
  if (coverage.tilt_deg < kTilt_deg_min) {
    return {"the board is seen from straight ahead alone",
            "tilt the device to all sides, by 30 degrees"};
  }
  if (coverage.roll_deg < kRoll_deg_min) {
    return {"the device was never turned about its line of sight",
            "turn it by a quarter to both sides, the board in view"};
  }
  if (coverage.near_to_far < kNearToFarMin) {
    return {"the board is seen from one distance alone", "move from near to far"};
  }
  for (int c = 0; c < cameras; ++c) {
    const char* const side = bare_side(coverage, c);
    if (side == nullptr) continue;
    return {std::string("the board was never at the ") + side + " rim of cam" + std::to_string(c),
            "have it all over both images, rims and corners too"};
  }
  return {};
}

std::string picture(const Coverage& coverage, int camera) {
  std::string out;
  for (const auto& row : coverage.cells[camera]) {
    for (const int count : row) {
      out += count == 0 ? '.' : count > 9 ? '#' : char('0' + count);
    }
    out += '\n';
  }
  return out;
}

}  // namespace pirvs::tools
