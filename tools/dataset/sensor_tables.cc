#include "tools/dataset/sensor_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tools/dataset/input_error.h"
#include "tools/dataset/text_table.h"

namespace pirvs::tools {
namespace {

constexpr size_t kValues = 6;
constexpr double kG_m_s2 = 9.80665;
constexpr double kDegree = M_PI / 180;

template <class Row>
void sort_and_drop(std::vector<Row>& rows, const std::string& what, InputLog& log) {
  size_t late = 0;
  TimeNs newest = INT64_MIN;
  for (const Row& row : rows) {
    late += row.t < newest;
    newest = std::max(newest, row.t);
  }
  if (late > 0) {
    std::stable_sort(rows.begin(), rows.end(),
                     [](const Row& a, const Row& b) { return a.t < b.t; });
  }
  const auto end =
      std::unique(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.t == b.t; });
  log.count(what + "_out_of_order", late);
  log.count(what + "_repeated", size_t(rows.end() - end));
  rows.erase(end, rows.end());
}

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return out;
}

std::vector<std::string> names_of(std::string_view heading) {
  std::vector<std::string> out;
  while (!heading.empty()) {
    const size_t end = std::min(heading.find_first_of(",;\t"), heading.size());
    std::string name = lower(heading.substr(0, end));
    name.erase(0, std::min(name.find_first_not_of(' '), name.size()));
    out.push_back(name);
    heading.remove_prefix(std::min(end + 1, heading.size()));
  }
  return out;
}

bool has(const std::string& name, std::initializer_list<const char*> parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](const char* part) { return name.find(part) != std::string::npos; });
}

bool begins(const std::string& name, std::initializer_list<const char*> parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](const char* part) { return name.rfind(part, 0) == 0; });
}

// Where the six values stand, and by what they are multiplied.
struct Columns {
  std::array<size_t, kValues> at = {1, 2, 3, 4, 5, 6};
  double gyro = 1, accel = 1;
};

Columns columns_of(const TextTable& table, const std::string& path, InputLog& log) {
  const auto names = names_of(table.heading());
  std::vector<size_t> gyro, accel;
  Columns out;
  for (size_t i = 1; i < names.size(); ++i) {
    const std::string& name = names[i];
    if (has(name, {"cov", "orient", "bias", "mag", "temp"})) continue;
    if (has(name, {"gyr", "omega", "angular"}) ||
        begins(name, {"w_", "wx", "wy", "wz", "gx", "gy", "gz"})) {
      gyro.push_back(i);
      if (has(name, {"deg"})) out.gyro = kDegree;
    } else if (has(name, {"acc", "linear"}) || begins(name, {"a_", "ax", "ay", "az"})) {
      accel.push_back(i);
      if (has(name, {"[g]", "(g)"})) out.accel = kG_m_s2;
    }
  }
  if (gyro.size() == 3 && accel.size() == 3) {
    for (size_t k = 0; k < 3; ++k) {
      out.at[k] = gyro[k];
      out.at[3 + k] = accel[k];
    }
    if (gyro[0] != 1 || accel[0] != 4) {
      log.note("IMU samples: columns are taken by the names in the heading of " + path);
    }
  } else if (!names.empty() && has(lower(table.heading()), {"orient", "q_w", "qw", "q_x", "qx"})) {
    throw InputError(
        "IMU samples: the heading has columns of an orientation, and no six that are "
        "clearly gyro and accelerometer",
        path, "name them w_x,w_y,w_z,a_x,a_y,a_z in the heading");
  }
  if (out.gyro != 1) log.note("IMU samples: deg/s as the heading says, taken as rad/s");
  if (out.accel != 1) log.note("IMU samples: g as the heading says, taken as 9.80665 m/s^2");
  return out;
}

}  // namespace

std::vector<ListedImage> read_image_list(const std::string& path, InputLog& log, Rows rows,
                                         const StampRule& rule) {
  TextTable table(path, "list of images", rule);
  return read_image_list(table, path, log, rows);
}

std::vector<ListedImage> read_image_list(TextTable& table, const std::string& path, InputLog& log,
                                         Rows rows) {
  std::vector<ListedImage> images;
  bool stamps_alone = false;
  while (table.next()) {
    const auto t = table.stamp();
    if (images.empty()) stamps_alone = table.columns() == 1 && !table.cut_off();
    if (!t || (table.columns() < 2 && !stamps_alone)) {
      if (!table.cut_off()) table.fail("needs 'stamp,file name'", "remove or repair the line");
      log.count("image_rows_truncated");
      continue;
    }
    images.push_back({*t, std::string(table.text(stamps_alone ? 0 : 1))});
  }
  if (images.empty()) throw InputError("no images listed", path, "check the recording");
  if (rows == Rows::kInOrderOfTime) put_in_order(images, "image_rows", log);
  return images;
}

std::vector<ImuSample> read_imu_samples(const std::string& path, InputLog& log, Rows rows,
                                        const StampRule& rule) {
  TextTable table(path, "IMU samples", rule);
  return read_imu_samples(table, path, log, rows);
}

std::vector<ImuSample> read_imu_samples(TextTable& table, const std::string& path, InputLog& log,
                                        Rows rows) {
  const Columns columns = columns_of(table, path, log);
  const size_t last = *std::max_element(columns.at.begin(), columns.at.end());
  std::vector<ImuSample> samples;
  while (table.next()) {
    const auto t = table.stamp();
    double v[kValues] = {};
    bool complete = t && table.columns() > last;
    bool finite = true;
    for (size_t k = 0; k < kValues && complete; ++k) {
      const auto value = table.number(columns.at[k]);
      complete = value.has_value();
      v[k] = value.value_or(0);
      finite = finite && std::isfinite(v[k]);
    }
    if (!complete) {
      if (!table.cut_off()) table.fail("needs 7 numbers", "remove or repair the line");
      log.count("imu_rows_truncated");
    } else if (!finite && rows == Rows::kInOrderOfTime) {
      log.count("imu_samples_not_finite");
    } else {
      samples.push_back(
          {*t, columns.gyro * Vec3(v[0], v[1], v[2]), columns.accel * Vec3(v[3], v[4], v[5])});
    }
  }
  if (samples.empty()) throw InputError("no IMU samples", path, "check the recording");
  if (rows == Rows::kInOrderOfTime) put_in_order(samples, "imu_rows", log);
  return samples;
}

void put_in_order(std::vector<ListedImage>& images, const std::string& what, InputLog& log) {
  sort_and_drop(images, what, log);
}

void put_in_order(std::vector<ImuSample>& samples, const std::string& what, InputLog& log) {
  sort_and_drop(samples, what, log);
}

}  // namespace pirvs::tools
