#include "tools/dataset/trajectory.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tools/dataset/input_error.h"
#include "tools/dataset/text_table.h"

namespace pirvs::tools {
namespace {

constexpr size_t kTumColumns = 8;
constexpr size_t kAslStateColumns = 17;
constexpr size_t kMatrixColumns = 13;
constexpr char kFormats[] = "give a TUM file or an ASL state_groundtruth_estimate0/data.csv";

bool numbers(const TextTable& table, size_t first, size_t count, double* out) {
  for (size_t i = 0; i < count; ++i) {
    const auto value = table.number(first + i);
    if (!value) return false;
    out[i] = *value;
  }
  return true;
}

bool finite(const double* values, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    if (!std::isfinite(values[i])) return false;
  }
  return true;
}

Vec4 quat_of_matrix(const double* m) {
  Mat3 R;
  R << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  return Eigen::Quaterniond(R).normalized().coeffs();
}

// Fills everything but the stamp from the columns behind it.
void decode(const double* value, size_t columns, bool commas, TrajectoryPose& out) {
  if (columns == kMatrixColumns && !commas) {
    out.p_WB = Vec3(value[3], value[7], value[11]);
    out.q_WB = quat_of_matrix(value);
    return;
  }
  out.p_WB = Vec3(value[0], value[1], value[2]);
  out.q_WB = commas ? Vec4(value[4], value[5], value[6], value[3])
                    : Vec4(value[3], value[4], value[5], value[6]);
  if (columns >= kAslStateColumns) {
    out.v_WB = Vec3(value[7], value[8], value[9]);
    out.b_g = Vec3(value[10], value[11], value[12]);
    out.b_a = Vec3(value[13], value[14], value[15]);
  }
}

}  // namespace

Trajectory read_trajectory(const std::string& path, const StampRule& rule) {
  TextTable table(path, "trajectory", rule);
  Trajectory out;
  size_t columns = 0;
  while (table.next()) {
    if (columns == 0) columns = table.columns();
    double value[kAslStateColumns] = {};
    const size_t used = std::min(columns, kAslStateColumns) - 1;
    const auto t = table.stamp();
    if (!t || table.columns() < columns || !numbers(table, 1, used, value)) {
      if (table.cut_off()) {
        ++out.rows_truncated;
        break;
      }
      table.fail("not a row of numbers like the first one", "remove or repair the line");
    }
    if (columns < kTumColumns) table.fail("fewer than 8 columns", kFormats);
    if (!finite(value, used)) table.fail("a value is not finite", "remove the line");
    TrajectoryPose pose;
    pose.t = *t;
    // Decimal seconds take strtod's rounding, integers one division: what scripts compute with.
    const std::string text(table.text(0));
    const bool decimal = table.unit() == StampUnit::kSeconds && text.find('.') != std::string::npos;
    pose.t_s = decimal ? std::strtod(text.c_str(), nullptr) : double(*t) / 1e9;
    decode(value, columns, table.has_commas(), pose);
    const double norm = pose.q_WB.norm();
    if (!(norm > 1e-3 && norm < 1e3)) {
      table.fail("the quaternion is zero or far from a unit one", "remove the line");
    }
    pose.q_WB /= norm;
    if (!out.poses.empty() && pose.t <= out.poses.back().t) {
      table.fail("the stamp is not after the one before", "sort the file by time");
    }
    out.poses.push_back(pose);
  }
  if (out.poses.empty()) throw InputError("trajectory has no poses", path, kFormats);
  out.full_state = columns >= kAslStateColumns;
  return out;
}

std::string tum_line(TimeNs t, const Vec3& p_WB, const Vec4& q_WB) {
  constexpr TimeNs kSecond = 1'000'000'000;
  char line[2560];  // even of coordinates that nobody has
  std::snprintf(line, sizeof line, "%lld.%09lld %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n",
                static_cast<long long>(t / kSecond), static_cast<long long>(t % kSecond), p_WB.x(),
                p_WB.y(), p_WB.z(), q_WB[0], q_WB[1], q_WB[2], q_WB[3]);
  return line;
}

}  // namespace pirvs::tools
