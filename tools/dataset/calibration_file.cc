#include "tools/dataset/calibration_file.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/LU>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "core/math/so3.h"
#include "modules/calibration/calibration_check.h"
#include "modules/calibration/calibration_text.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// A YAML file that says where it was wrong.
class Source {
 public:
  explicit Source(const std::string& path) : path_(path) {
    if (!std::filesystem::is_regular_file(path)) {
      throw InputError("no calibration file", path, "add it, or give one with --calib");
    }
    try {
      root_ = YAML::LoadFile(path);
    } catch (const YAML::Exception& error) {
      fail("not YAML", "line " + std::to_string(error.mark.line + 1));
    }
    if (!root_.IsMap()) fail("not a calibration", "the file");
  }

  const YAML::Node& root() const { return root_; }

  [[noreturn]] void fail(const std::string& what, const std::string& key) const {
    throw InputError(what, path_ + ", " + key, "repair the calibration");
  }

  template <class T>
  T get(const YAML::Node& node, const char* key) const {
    if (!node.IsMap() || !node[key]) fail("missing value", key);
    try {
      return node[key].as<T>();
    } catch (const YAML::Exception&) {
      fail("value of the wrong kind", key);
    }
  }

  std::vector<double> numbers(const YAML::Node& node, const char* key, size_t count) const {
    const auto values = get<std::vector<double>>(node, key);
    if (values.size() != count) fail("needs " + std::to_string(count) + " numbers", key);
    for (const double v : values) {
      if (!std::isfinite(v)) fail("a number is not finite", key);
    }
    return values;
  }

 private:
  std::string path_;
  YAML::Node root_;
};

SE3 transform(const Source& source, const std::vector<double>& m, const char* key) {
  SE3 T;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) T.R(i, j) = m[size_t(4 * i + j)];
    T.p[i] = m[size_t(4 * i + 3)];
  }
  constexpr double kPrinted = 1e-3;  // what rounding to a few digits may cost
  const bool rotation =
      (T.R * T.R.transpose() - Mat3::Identity()).norm() < kPrinted && T.R.determinant() > 0;
  if (!rotation) source.fail("the 3 x 3 part is not a rotation", key);
  // What is one to the last bits stays, so that a recording of a recording gives the same run.
  constexpr double kExact = 4e-15;
  if ((T.R * T.R.transpose() - Mat3::Identity()).norm() > kExact) T.R = orthonormalized(T.R);
  return T;
}

SE3 asl_transform(const Source& source) {
  const YAML::Node node = source.root()["T_BS"];
  if (!node) source.fail("missing value", "T_BS");
  return transform(source, source.numbers(node, "data", 16), "T_BS");
}

SE3 kalibr_transform(const Source& source, const YAML::Node& camera, const char* key) {
  const auto rows = source.get<std::vector<std::vector<double>>>(camera, key);
  std::vector<double> m;
  for (const auto& row : rows) m.insert(m.end(), row.begin(), row.end());
  if (m.size() != 16) source.fail("needs 4 rows of 4 numbers", key);
  return transform(source, m, key);
}

// Everything but T_BC: the two formats differ in one key's name alone.
Camera read_intrinsics(const Source& source, const YAML::Node& node, const char* coefficients) {
  Camera camera{};
  const auto size = source.get<std::vector<int>>(node, "resolution");
  if (size.size() != 2 || size[0] < 16 || size[1] < 16) {
    source.fail("needs width and height", "resolution");
  }
  camera.width = size[0];
  camera.height = size[1];
  const auto projection = source.get<std::string>(node, "camera_model");
  if (projection != "pinhole") source.fail("unknown model '" + projection + "'", "camera_model");
  const auto distortion = source.get<std::string>(node, "distortion_model");
  if (distortion == "radial-tangential" || distortion == "radtan") {
    camera.model = CameraModel::kPinholeRadtan;
  } else if (distortion == "equidistant") {
    camera.model = CameraModel::kKannalaBrandt;
  } else {
    source.fail("unknown model '" + distortion + "' (known: radtan, equidistant)",
                "distortion_model");
  }
  const auto k = source.numbers(node, "intrinsics", 4);
  if (k[0] <= 0 || k[1] <= 0) source.fail("the focal length is not positive", "intrinsics");
  camera.fx = k[0];
  camera.fy = k[1];
  camera.cx = k[2];
  camera.cy = k[3];
  const auto d = source.numbers(node, coefficients, 4);
  for (size_t i = 0; i < 4; ++i) camera.d[i] = d[i];
  return camera;
}

// Kalibr's key; our own recordings have it in the ASL sensor.yaml, too.
TimeNs time_offset(const Source& source, const YAML::Node& camera) {
  constexpr const char* kKey = "timeshift_cam_imu";
  constexpr double kOffset_s_max = 1e6;
  if (!camera[kKey]) return 0;
  const auto shift_s = source.get<double>(camera, kKey);
  if (!(std::abs(shift_s) < kOffset_s_max)) source.fail("needs a number of seconds", kKey);
  return from_seconds(shift_s);
}

ImuNoise imu_noise(const Source& source) {
  ImuNoise noise;
  const YAML::Node& root = source.root();
  const auto positive = [&](const char* key) {
    const double value = source.get<double>(root, key);
    if (!(value > 0)) source.fail("needs a number above 0", key);
    return value;
  };
  noise.gyro_noise = positive("gyroscope_noise_density");
  noise.gyro_walk = positive("gyroscope_random_walk");
  noise.accel_noise = positive("accelerometer_noise_density");
  noise.accel_walk = positive("accelerometer_random_walk");
  noise.rate_hz = root["update_rate"] ? positive("update_rate") : positive("rate_hz");
  return noise;
}

}  // namespace

ImuNoise read_imu_noise(const std::string& path) { return imu_noise(Source(path)); }

Camera read_asl_camera(const std::string& path, TimeNs& offset) {
  const Source source(path);
  Camera camera = read_intrinsics(source, source.root(), "distortion_coefficients");
  camera.T_BC = asl_transform(source);
  offset = time_offset(source, source.root());
  return camera;
}

GnssSensor read_gnss_sensor(const std::string& path) {
  constexpr double kSeconds_max = 10;
  const Source source(path);
  const YAML::Node& root = source.root();
  const auto seconds = [&](const char* key) {
    if (!root[key]) return TimeNs{0};
    const double value = source.get<double>(root, key);
    if (!(std::abs(value) < kSeconds_max)) source.fail("needs a few seconds at most", key);
    return from_seconds(value);
  };
  GnssSensor out;
  if (root["T_BS"]) out.antenna.p_BA = asl_transform(source).p;
  out.antenna.time_offset_ns = seconds("time_offset");
  out.latency_ns = seconds("latency");
  if (out.latency_ns < 0) source.fail("needs a number not below 0", "latency");
  if (!root["truth_world"]) return out;
  const auto truth = source.numbers(root, "truth_world", 4);
  out.has_truth = true;
  out.truth_latitude_deg = truth[0];
  out.truth_longitude_deg = truth[1];
  out.truth_height_m = truth[2];
  out.truth_heading_deg = truth[3];
  return out;
}

WheelSensor read_wheel_sensor(const std::string& path) {
  constexpr const char* kKinds[kWheelKinds] = {"left_right", "twist", "ticks", "steering"};
  constexpr double kSeconds_max = 10;
  const Source source(path);
  const YAML::Node& root = source.root();
  const auto kind = source.get<std::string>(root, "kind");
  const auto found = std::find(std::begin(kKinds), std::end(kKinds), kind);
  if (found == std::end(kKinds)) {
    source.fail("unknown wheels '" + kind + "' (known: left_right, twist, ticks, steering)",
                "kind");
  }
  const auto length = [&](const char* key, bool needed) {
    if (!root[key] && !needed) return 0.0;
    const double value = source.get<double>(root, key);
    if (!(value > 0)) source.fail("needs a number above 0", key);
    return value;
  };
  WheelSensor out;
  out.kind = WheelKind(found - std::begin(kKinds));
  WheelCalibration& wheels = out.calibration;
  wheels.known = true;
  wheels.T_BV = asl_transform(source);
  wheels.track_m = length("track", false);
  wheels.wheelbase_m = length("wheelbase", out.kind == WheelKind::kSteering);
  if (out.kind == WheelKind::kTicks) {
    wheels.tick_m = 2 * M_PI * length("radius", true) / length("ticks_per_turn", true);
  }
  if (root["time_offset"]) {
    const double offset_s = source.get<double>(root, "time_offset");
    if (!(std::abs(offset_s) < kSeconds_max)) {
      source.fail("needs a few seconds at most", "time_offset");
    }
    wheels.time_offset_ns = from_seconds(offset_s);
  }
  return out;
}

Calibration read_asl_calibration(const std::string& mav0) {
  Calibration out;
  const Source imu(mav0 + "/imu0/sensor.yaml");
  out.imu = imu_noise(imu);
  // The file's body and the IMU are nearly always one; where not, ours is the IMU.
  const SE3 T_SB = imu.root()["T_BS"] ? asl_transform(imu).inverse() : SE3{};
  out.cameras = std::filesystem::exists(mav0 + "/cam1") ? 2 : 1;
  for (int c = 0; c < out.cameras; ++c) {
    TimeNs offset = 0;
    out.camera[c] = read_asl_camera(mav0 + "/cam" + std::to_string(c) + "/sensor.yaml", offset);
    out.camera[c].T_BC = T_SB * out.camera[c].T_BC;
    if (c == 0) out.camera_time_offset_ns = offset;
  }
  const std::string wheels = mav0 + "/wheel0/sensor.yaml";
  if (std::filesystem::exists(wheels)) {
    out.wheels = read_wheel_sensor(wheels).calibration;
    out.wheels.T_BV = T_SB * out.wheels.T_BV;
  }
  const std::string gnss = mav0 + "/gnss0/sensor.yaml";
  if (!std::filesystem::exists(gnss)) return out;
  out.gnss = read_gnss_sensor(gnss).antenna;
  out.gnss.p_BA = T_SB * out.gnss.p_BA;
  return out;
}

void check_sense(const Calibration& calibration, const std::string& where) {
  if (const CalibrationFault fault = find_fault(calibration)) {
    throw InputError(fault.what, where + ", " + fault.where, fault.what_to_do);
  }
}

Calibration read_calibration_file(const std::string& path, const ImuNoise& noise) {
  if (std::filesystem::path(path).extension() != ".cfg") {
    return read_kalibr_calibration(path, noise);
  }
  std::stringstream text;
  if (!(text << std::ifstream(path).rdbuf())) {
    throw InputError("no calibration file", path, "add it, or give one with --calib");
  }
  const std::string all = text.str();  // a fault names a part of it
  Calibration out;
  if (const ConfigFault fault = read_calibration(all, out)) {
    Text<512> line;
    put_fault(line, path.c_str(), fault);
    throw InputError("not a calibration", line.c_str(), "repair the calibration");
  }
  return out;
}

Calibration read_kalibr_calibration(const std::string& path, const ImuNoise& noise) {
  const Source source(path);
  Calibration out;
  const auto beside = std::filesystem::path(path).parent_path() / "imu.yaml";
  out.imu = std::filesystem::exists(beside) ? read_imu_noise(beside.string()) : noise;
  out.cameras = source.root()["cam1"] ? 2 : 1;
  SE3 T_CB_before;
  for (int c = 0; c < out.cameras; ++c) {
    const std::string name = "cam" + std::to_string(c);
    const YAML::Node camera = source.root()[name];
    if (!camera || !camera.IsMap()) source.fail("missing value", name);
    out.camera[c] = read_intrinsics(source, camera, "distortion_coeffs");
    const bool own = bool(camera["T_cam_imu"]);
    if (!own && c == 0) source.fail("missing value (camchain-imucam.yaml has it)", "T_cam_imu");
    const SE3 T_CB = own ? kalibr_transform(source, camera, "T_cam_imu")
                         : kalibr_transform(source, camera, "T_cn_cnm1") * T_CB_before;
    out.camera[c].T_BC = T_CB.inverse();
    T_CB_before = T_CB;
  }
  out.camera_time_offset_ns = time_offset(source, source.root()["cam0"]);
  return out;
}

}  // namespace pirvs::tools
