#include "tools/dataset/loose_tables.h"

#include <algorithm>
#include <fstream>

#include "tools/dataset/input_error.h"
#include "tools/dataset/sensor_tables.h"

namespace pirvs::tools {
namespace {

// Without a column in front that counts rows from 0 or 1 on.
std::string without_counter(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string out, line;
  double expected = -1;
  bool counts = true;
  size_t rows = 0;
  std::vector<std::string> kept;
  while (std::getline(file, line)) {
    const size_t end = line.find_first_of(",;\t ");
    const auto number = stamp_number(line.substr(0, end));
    if (number && end != std::string::npos) {
      const bool begins = rows == 0 && (*number == 0 || *number == 1);
      counts = counts && (begins || (rows > 0 && *number == expected));
      expected = *number + 1;
      ++rows;
    } else if (number) {
      counts = false;
    }
    kept.push_back(end == std::string::npos ? line : line.substr(end + 1));
  }
  if (!counts || rows < 2) return "";
  for (const std::string& one : kept) out += one + "\n";
  return out;
}

}  // namespace

std::unique_ptr<TextTable> open_frame_stamps(const std::string& path, const StampRule& rule) {
  const std::string rest = without_counter(path);
  if (rest.empty()) return std::make_unique<TextTable>(path, "stamps of frames", rule);
  return std::make_unique<TextTable>(TextTable::Content{rest}, path, "stamps of frames", rule);
}

std::vector<ImuSample> read_triples(TextTable& table, Vec3 ImuSample::*vector,
                                    const std::string& path, InputLog& log) {
  std::vector<ImuSample> out;
  while (table.next()) {
    const auto t = table.stamp();
    const auto x = table.number(1), y = table.number(2), z = table.number(3);
    if (!t || !x || !y || !z) {
      if (!table.cut_off()) table.fail("needs stamp, x, y, z", "remove or repair the line");
      log.count("imu_rows_truncated");
      continue;
    }
    ImuSample sample;
    sample.t = *t;
    sample.*vector = Vec3(*x, *y, *z);
    if ((sample.*vector).allFinite()) {
      out.push_back(sample);
    } else {
      log.count("imu_samples_not_finite");
    }
  }
  if (out.size() < 2) throw InputError("no IMU samples", path, "check the recording");
  put_in_order(out, "imu_rows", log);
  return out;
}

void put_gyro_first(std::vector<ImuSample>& samples, InputLog& log) {
  constexpr double kGravity_min = 8, kGravity_max = 12, kGyro_max = 5;
  const auto middle = [&](Vec3 ImuSample::*vector) {
    std::vector<double> sizes;
    for (const ImuSample& sample : samples) sizes.push_back((sample.*vector).norm());
    const auto at = sizes.begin() + std::ptrdiff_t(sizes.size() / 2);
    std::nth_element(sizes.begin(), at, sizes.end());
    return *at;
  };
  const double gravity = middle(&ImuSample::w_B);
  if (gravity < kGravity_min || gravity > kGravity_max || middle(&ImuSample::f_B) > kGyro_max) {
    return;
  }
  for (ImuSample& sample : samples) std::swap(sample.w_B, sample.f_B);
  log.note("IMU samples: gravity is in the first three columns: taken as accelerometer");
}

}  // namespace pirvs::tools
