#include "modules/calibration/calibration_text.h"

#include <Eigen/LU>
#include <iterator>

#include "core/base/limits.h"
#include "core/math/so3.h"

namespace pirvs {
namespace {

constexpr int64_t kSide_max = 65'536;
constexpr int64_t kOffset_ns_max = 1'000'000'000'000;
constexpr const char* kNumbers = "not as many numbers as belong here";

struct Model {
  const char* name;
  CameraModel model;
};
constexpr Model kModels[] = {{"radtan", CameraModel::kPinholeRadtan},
                             {"equidistant", CameraModel::kKannalaBrandt}};

// Each reads a value: nullptr, or what is wrong.
const char* read_model(std::string_view value, Camera& out) {
  for (const Model& model : kModels) {
    if (value != model.name) continue;
    out.model = model.model;
    return nullptr;
  }
  return "the models are radtan and equidistant";
}

const char* read_size(std::string_view value, Camera& out) {
  std::string_view words[2];
  int64_t width = 0, height = 0;
  const bool good = read_words(value, words, 2) && read_whole(words[0], 1, kSide_max, width) &&
                    read_whole(words[1], 1, kSide_max, height);
  if (!good) return "needs width and height in pixels";
  out.width = static_cast<int>(width);
  out.height = static_cast<int>(height);
  return nullptr;
}

const char* read_two(std::string_view value, double& first, double& second) {
  double numbers[2];
  if (!read_numbers(value, numbers, 2)) return kNumbers;
  first = numbers[0];
  second = numbers[1];
  return nullptr;
}

const char* read_focal(std::string_view value, Camera& out) {
  return read_two(value, out.fx, out.fy);
}

const char* read_centre(std::string_view value, Camera& out) {
  return read_two(value, out.cx, out.cy);
}

const char* read_distortion(std::string_view value, Camera& out) {
  return read_numbers(value, out.d, std::size(out.d)) ? nullptr : kNumbers;
}

const char* read_pose(std::string_view value, SE3& out) {
  double m[12];
  if (!read_numbers(value, m, 12)) return kNumbers;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) out.R(i, j) = m[4 * i + j];
    out.p(i) = m[4 * i + 3];
  }
  // What printing has cost is taken back; what is no rotation at all is found by find_fault.
  constexpr double kExact = 4e-15, kPrinted = 1e-3;
  const Mat3& R = out.R;
  const double error = (R * R.transpose() - Mat3::Identity()).norm();
  const bool rotation = error < kPrinted && R.determinant() > 0;
  if (rotation && error > kExact) out.R = orthonormalized(R);
  return nullptr;
}

const char* read_camera_pose(std::string_view value, Camera& out) {
  return read_pose(value, out.T_BC);
}

const char* read_offset(std::string_view value, TimeNs& out) {
  int64_t whole = 0;
  if (!read_whole(value, -kOffset_ns_max, kOffset_ns_max, whole)) {
    return "needs whole nanoseconds, below 1000 s";
  }
  out = whole;
  return nullptr;
}

struct CameraKey {
  const char* name;
  const char* (*read)(std::string_view, Camera&);
};
constexpr CameraKey kCameraKeys[] = {
    {"model", read_model},   {"size", read_size},        {"focal", read_focal},
    {"centre", read_centre}, {"T_BC", read_camera_pose}, {"distortion", read_distortion},
};

struct ImuKey {
  const char* name;
  double ImuNoise::*field;
};
constexpr ImuKey kImuKeys[] = {
    {"gyro_noise", &ImuNoise::gyro_noise},   {"gyro_walk", &ImuNoise::gyro_walk},
    {"accel_noise", &ImuNoise::accel_noise}, {"accel_walk", &ImuNoise::accel_walk},
    {"rate_hz", &ImuNoise::rate_hz},
};

struct IntrinsicsKey {
  const char *matrix_name, *bias_name;
  Mat3 ImuIntrinsics::*matrix;
  Vec3 ImuIntrinsics::*bias;
};
constexpr IntrinsicsKey kIntrinsicsKeys[] = {
    {"gyro_matrix", "gyro_bias", &ImuIntrinsics::gyro, &ImuIntrinsics::b_g},
    {"accel_matrix", "accel_bias", &ImuIntrinsics::accel, &ImuIntrinsics::b_a},
};

// Whether it is one of these keys; `what` is wrong with it then, or nothing.
bool read_intrinsics(std::string_view key, std::string_view value, ImuIntrinsics& out,
                     const char*& what) {
  for (const IntrinsicsKey& known : kIntrinsicsKeys) {
    if (key == known.bias_name) {
      what = read_numbers(value, (out.*known.bias).data(), 3) ? nullptr : kNumbers;
      return true;
    }
    if (key != known.matrix_name) continue;
    double m[9];
    what = read_numbers(value, m, 9) ? nullptr : kNumbers;
    for (int i = 0; what == nullptr && i < 9; ++i) (out.*known.matrix)(i / 3, i % 3) = m[i];
    return true;
  }
  return false;
}

constexpr const char* kCameraNames[kCamerasMax] = {"cam0.", "cam1."};
constexpr const char* kImuName = "imu.";
constexpr const char* kGnssName = "gnss.";

const char* read_gnss(std::string_view key, std::string_view value, GnssAntenna& out) {
  if (key == "antenna") return read_numbers(value, out.p_BA.data(), 3) ? nullptr : kNumbers;
  if (key == "time_offset_ns") return read_offset(value, out.time_offset_ns);
  return "no such key in a calibration";
}

constexpr const char* kWheelsName = "wheels.";

struct WheelKey {
  const char* name;
  double WheelCalibration::*field;
};
constexpr WheelKey kWheelKeys[] = {
    {"track_m", &WheelCalibration::track_m},
    {"wheelbase_m", &WheelCalibration::wheelbase_m},
    {"tick_m", &WheelCalibration::tick_m},
};

// T_BV says that there are any.
const char* read_wheels(std::string_view key, std::string_view value, WheelCalibration& out) {
  if (key == "T_BV") {
    out.known = true;
    return read_pose(value, out.T_BV);
  }
  if (key == "time_offset_ns") return read_offset(value, out.time_offset_ns);
  for (const WheelKey& wheel : kWheelKeys) {
    if (key == wheel.name) return read_numbers(value, &(out.*wheel.field), 1) ? nullptr : kNumbers;
  }
  return "no such key in a calibration";
}

// Which keys have been there, a bit each.
struct Seen {
  uint32_t camera[kCamerasMax] = {};
  uint32_t imu = 0;
  bool cameras = false;
};

const char* read_line(const KeyValue& line, Calibration& out, Seen& seen) {
  int64_t whole = 0;
  if (line.key == "cameras") {
    if (!read_whole(line.value, 1, kCamerasMax, whole)) return "there are 1 or 2 cameras";
    out.cameras = static_cast<int>(whole);
    seen.cameras = true;
    return nullptr;
  }
  if (line.key == "camera_time_offset_ns") {
    return read_offset(line.value, out.camera_time_offset_ns);
  }
  const std::string_view gnss = behind(line.key, kGnssName);
  if (!gnss.empty()) return read_gnss(gnss, line.value, out.gnss);
  const std::string_view wheels = behind(line.key, kWheelsName);
  if (!wheels.empty()) return read_wheels(wheels, line.value, out.wheels);
  for (int c = 0; c < kCamerasMax; ++c) {
    const std::string_view name = behind(line.key, kCameraNames[c]);
    for (size_t i = 0; i < std::size(kCameraKeys); ++i) {
      if (name != kCameraKeys[i].name) continue;
      seen.camera[c] |= 1u << i;
      return kCameraKeys[i].read(line.value, out.camera[c]);
    }
  }
  const std::string_view name = behind(line.key, kImuName);
  const char* what = nullptr;
  if (read_intrinsics(name, line.value, out.imu_intrinsics, what)) return what;
  for (size_t i = 0; i < std::size(kImuKeys); ++i) {
    if (name != kImuKeys[i].name) continue;
    seen.imu |= 1u << i;
    return read_numbers(line.value, &(out.imu.*kImuKeys[i].field), 1) ? nullptr : kNumbers;
  }
  return "no such key in a calibration";
}

ConfigFault find_missing(const Calibration& calibration, const Seen& seen) {
  if (!seen.cameras) return {0, "a key is missing", "cameras"};
  for (int c = 0; c < calibration.cameras; ++c) {
    for (size_t i = 0; i < std::size(kCameraKeys); ++i) {
      if ((seen.camera[c] >> i & 1u) != 0) continue;
      return {0, c == 0 ? "a key of cam0 is missing" : "a key of cam1 is missing",
              kCameraKeys[i].name};
    }
  }
  for (size_t i = 0; i < std::size(kImuKeys); ++i) {
    if ((seen.imu >> i & 1u) == 0) return {0, "a key of imu is missing", kImuKeys[i].name};
  }
  return {};
}

void put_numbers(TextWriter& out, const char* prefix, const char* key, const double* numbers,
                 int count) {
  out.put(prefix).put(key).put(" =");
  for (int i = 0; i < count; ++i) out.put(' ').exact(numbers[i]);
  out.put('\n');
}

void put_pose(TextWriter& out, const char* prefix, const char* key, const SE3& T) {
  double m[12];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[4 * i + j] = T.R(i, j);
    m[4 * i + 3] = T.p(i);
  }
  put_numbers(out, prefix, key, m, 12);
}

void write_camera(const Camera& camera, const char* prefix, TextWriter& out) {
  for (const Model& model : kModels) {
    if (model.model == camera.model) out.put(prefix).put("model = ").put(model.name).put('\n');
  }
  out.put(prefix).put("size = ").number(camera.width).put(' ').number(camera.height).put('\n');
  const double focal[] = {camera.fx, camera.fy}, centre[] = {camera.cx, camera.cy};
  put_numbers(out, prefix, "focal", focal, 2);
  put_numbers(out, prefix, "centre", centre, 2);
  put_numbers(out, prefix, "distortion", camera.d, std::size(camera.d));
  put_pose(out, prefix, "T_BC", camera.T_BC);
}

void write_intrinsics(const ImuIntrinsics& intrinsics, TextWriter& out) {
  if (!intrinsics.given()) return;
  for (const IntrinsicsKey& key : kIntrinsicsKeys) {
    double m[9];
    for (int i = 0; i < 9; ++i) m[i] = (intrinsics.*key.matrix)(i / 3, i % 3);
    put_numbers(out, kImuName, key.matrix_name, m, 9);
    put_numbers(out, kImuName, key.bias_name, (intrinsics.*key.bias).data(), 3);
  }
}

void write_wheels(const WheelCalibration& wheels, TextWriter& out) {
  if (!wheels.known) return;
  put_pose(out, kWheelsName, "T_BV", wheels.T_BV);
  for (const WheelKey& key : kWheelKeys) {
    if (wheels.*key.field > 0) put_numbers(out, kWheelsName, key.name, &(wheels.*key.field), 1);
  }
  if (wheels.time_offset_ns == 0) return;
  out.put(kWheelsName).put("time_offset_ns = ").number(wheels.time_offset_ns).put('\n');
}

}  // namespace

ConfigFault read_calibration(std::string_view text, Calibration& out) {
  out = Calibration{};
  Seen seen;
  KeyValues lines(text);
  KeyValue line;
  Status status = Status::kOk;
  while ((status = lines.next(line)) == Status::kOk) {
    const char* const what = read_line(line, out, seen);
    if (what != nullptr) return {line.line, what, line.key};
  }
  return status == Status::kBadData ? lines.fault() : find_missing(out, seen);
}

void write_calibration(const Calibration& calibration, TextWriter& out) {
  out.put("cameras = ").number(calibration.cameras).put('\n');
  out.put("camera_time_offset_ns = ").number(calibration.camera_time_offset_ns).put('\n');
  for (int c = 0; c < calibration.cameras; ++c) {
    write_camera(calibration.camera[c], kCameraNames[c], out);
  }
  for (const ImuKey& key : kImuKeys) {
    put_numbers(out, kImuName, key.name, &(calibration.imu.*key.field), 1);
  }
  write_intrinsics(calibration.imu_intrinsics, out);
  const GnssAntenna& gnss = calibration.gnss;
  if (!gnss.p_BA.isZero(0)) put_numbers(out, kGnssName, "antenna", gnss.p_BA.data(), 3);
  if (gnss.time_offset_ns != 0) {
    out.put(kGnssName).put("time_offset_ns = ").number(gnss.time_offset_ns).put('\n');
  }
  write_wheels(calibration.wheels, out);
}

}  // namespace pirvs
