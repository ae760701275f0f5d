#include "tools/dataset/calibration_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "modules/calibration/calibration_check.h"
#include "modules/calibration/calibration_text.h"
#include "tools/dataset/calibration/rig_file.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

std::string text_of(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// ---- lenses ------------------------------------------------------------------------------------
Camera camera_of(const RigCamera& read, const std::string& where, InputLog& log) {
  constexpr double kError_px_max = 0.1, kCorner_px_max = 3;
  const LensFit found = fit(read.lens);
  Camera camera = found.camera;
  camera.T_BC = read.T_BC;
  if (found.exact) return camera;
  const char* const model =
      camera.model == CameraModel::kPinholeRadtan ? "pinhole-radtan" : "pinhole-equidistant";
  if (!(found.error_px <= kError_px_max && found.corner_px <= kCorner_px_max)) {
    throw InputError("the lens's model is not computed here, and the nearest that is, " +
                         std::string(model) + ", is " + text_of("%.2f", found.error_px) +
                         " px off, " + text_of("%.1f", found.corner_px) + " in the corners",
                     where + ", " + read.name,
                     "calibrate again with pinhole-equi (fisheye) or pinhole-radtan");
  }
  log.note(read.name + ": its lens is fitted by " + model + ", at most " +
           text_of("%.3f", found.error_px) + " px off, " + text_of("%.2f", found.corner_px) +
           " in the corners");
  return camera;
}

// ---- noise -------------------------------------------------------------------------------------
// Names that people give to Kalibr's imu.yaml.
bool is_imu_name(const std::string& name) {
  for (const char* known : {"imu.yaml", "imu0.yaml", "kalibr_imu_chain.yaml", "imu_config.yaml",
                            "imu_chain.yaml", "imu_params.yaml", "ImuParams.yaml"}) {
    if (name == known) return true;
  }
  return name.rfind("imu-", 0) == 0 && name.size() > 9 && name.substr(name.size() - 5) == ".yaml";
}

std::optional<RigNoise> noise_beside(const std::string& path) {
  std::vector<std::string> names;
  std::error_code error;
  const fs::path folder = fs::path(path).has_parent_path() ? fs::path(path).parent_path() : ".";
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (is_imu_name(name)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  if (names.size() > 1 && std::find(names.begin(), names.end(), "imu.yaml") != names.end()) {
    names = {"imu.yaml"};
  }
  if (names.empty()) return std::nullopt;
  if (names.size() > 1) {
    throw InputError("noise densities in several files",
                     names[0] + ", " + names[1] + " beside " + path, "name one with --imu");
  }
  return find_noise((folder / names[0]).string());
}

RigNoise noise_from(const std::string& path) {
  if (const auto noise = find_noise(path)) return *noise;
  throw InputError("no noise densities of an IMU", path,
                   "missing value: gyroscope_noise_density and its like (docs/formats.md)");
}

void set_noise(const std::optional<RigNoise>& own, const std::optional<RigNoise>& usual,
               const std::string& path, const RigOptions& options, Rig& rig, InputLog& log) {
  std::optional<RigNoise> noise = own;
  if (!options.imu.empty()) noise = noise_from(options.imu);
  if (!noise) noise = noise_beside(path);
  const bool fallback = !noise && !options.fallback_imu.empty() && fs::exists(options.fallback_imu);
  if (fallback) noise = noise_from(options.fallback_imu);
  if (!noise) noise = usual;
  rig.has_rate = noise && noise->has_rate;
  if (noise) rig.calibration.imu = noise->noise;
  // Densities from elsewhere say nothing of them.
  if (noise && noise->intrinsics.given())
    rig.calibration.imu_intrinsics = noise->intrinsics;
  else if (own)
    rig.calibration.imu_intrinsics = own->intrinsics;
  const ImuNoise& used = rig.calibration.imu;
  log.note(
      (noise ? "IMU noise from " + noise->from : "no IMU noise is given, an ADIS16448's is taken") +
      ": gyro " + text_of("%.2g", used.gyro_noise) + " rad/s/sqrt(Hz), walk " +
      text_of("%.2g", used.gyro_walk) + ", accelerometer " + text_of("%.2g", used.accel_noise) +
      " m/s^2/sqrt(Hz), walk " + text_of("%.2g", used.accel_walk) +
      (noise ? "" : "; give yours with --imu"));
}

// ---- the pair ----------------------------------------------------------------------------------
SE3 right_in_left(const Rig& rig) {
  return rig.calibration.camera[0].T_BC.inverse() * rig.calibration.camera[1].T_BC;
}

// About how many quarter turns the right camera is rolled against the left one.
int quarters_of(const Mat3& R) {
  return (int(std::lround(std::atan2(R(1, 0), R(0, 0)) / M_PI_2)) + 4) % 4;
}

void arrange(Rig& rig, InputLog& log) {
  Calibration& calibration = rig.calibration;
  if (calibration.cameras < 2) return;
  const int quarters = quarters_of(right_in_left(rig).R);
  const std::string right = "cam" + std::to_string(rig.camera[1]);
  if (quarters != 0) {
    log.note(right + " is rolled by " + std::to_string(90 * quarters) + " degrees against cam" +
             std::to_string(rig.camera[0]) + ": its images are turned");
    calibration.camera[1] = turned(calibration.camera[1], quarters);
    rig.turns[1] = quarters;
  }
  const Vec3 p_C0C1 = right_in_left(rig).p;
  if (p_C0C1.x() > -0.5 * p_C0C1.norm()) return;
  log.note(right + " stands left of cam" + std::to_string(rig.camera[0]) +
           ": it is taken as the left one");
  std::swap(calibration.camera[0], calibration.camera[1]);
  std::swap(rig.camera[0], rig.camera[1]);
  std::swap(rig.turns[0], rig.turns[1]);
  std::swap(rig.shift_ns[0], rig.shift_ns[1]);
}

// Which of a file's cameras are asked for.
void choose(const RigOptions& options, size_t there, const std::string& where, Rig& rig) {
  const std::vector<int> wanted =
      options.cameras.empty() ? std::vector<int>{0, 1} : options.cameras;
  rig.calibration.cameras = int(std::min<size_t>(options.mono ? 1 : 2, wanted.size()));
  if (options.cameras.empty()) {
    rig.calibration.cameras = int(std::min(size_t(rig.calibration.cameras), there));
  }
  for (int c = 0; c < rig.calibration.cameras; ++c) {
    rig.camera[c] = wanted[size_t(c)];
    if (rig.camera[c] >= 0 && size_t(rig.camera[c]) < there) continue;
    throw InputError("there is no such camera", where + ", cam" + std::to_string(rig.camera[c]),
                     "choose other --cameras, there are " + std::to_string(there));
  }
}

void finish(const RigOptions& options, Rig& rig, InputLog& log) {
  if (!options.as_mounted) arrange(rig, log);
  rig.calibration.camera_time_offset_ns = rig.shift_ns[0];
}

}  // namespace

Camera turned(const Camera& camera, int quarters) {
  Camera out = camera;
  for (int i = 0; i < quarters; ++i) {  // (x, y) -> (height - 1 - y, x)
    const Camera before = out;
    std::swap(out.width, out.height);
    std::swap(out.fx, out.fy);
    out.cx = before.height - 1 - before.cy;
    out.cy = before.cx;
    if (out.model == CameraModel::kPinholeRadtan) {
      out.d[2] = before.d[3];
      out.d[3] = -before.d[2];
    }
    Mat3 R_before_out;
    R_before_out << 0, 1, 0, -1, 0, 0, 0, 0, 1;
    out.T_BC.R = before.T_BC.R * R_before_out;
  }
  return out;
}

Rig read_asl_rig(const std::string& mav0, const RigOptions& options, InputLog& log) {
  Rig rig;
  const Document imu(mav0 + "/imu0/sensor.yaml");
  const auto own = noise_of(imu);
  if (options.imu.empty()) {
    if (!own) imu.fail("missing value", "gyroscope_noise_density");
    if (!own->has_rate) imu.fail("missing value", "rate_hz");
    rig.calibration.imu = own->noise;
    rig.calibration.imu_intrinsics = own->intrinsics;
  } else {
    set_noise(own, std::nullopt, imu.path(), options, rig, log);
  }
  // The file's body and the IMU are nearly always one; where not, ours is the IMU.
  const SE3 T_SB =
      imu.has(imu.root(), "T_BS") ? imu.transform(imu.root(), "T_BS").inverse() : SE3{};
  size_t there = 0;
  while (fs::exists(mav0 + "/cam" + std::to_string(there))) ++there;
  choose(options, there, mav0, rig);
  for (int c = 0; c < rig.calibration.cameras; ++c) {
    const std::string name = "cam" + std::to_string(rig.camera[c]);
    const Document file(mav0 + "/" + name + "/sensor.yaml");
    RigCamera read = read_asl_sensor(file);
    read.name = name;
    read.T_BC = T_SB * read.T_BC;
    rig.shift_ns[c] = read.shift_ns;
    rig.calibration.camera[c] = camera_of(read, file.path(), log);
  }
  finish(options, rig, log);
  const std::string wheels = mav0 + "/wheel0/sensor.yaml";
  if (fs::exists(wheels)) {
    rig.calibration.wheels = read_wheel_sensor(wheels).calibration;
    rig.calibration.wheels.T_BV = T_SB * rig.calibration.wheels.T_BV;
  }
  const std::string gnss = mav0 + "/gnss0/sensor.yaml";
  if (!fs::exists(gnss)) return rig;
  rig.calibration.gnss = read_gnss_sensor(gnss).antenna;
  rig.calibration.gnss.p_BA = T_SB * rig.calibration.gnss.p_BA;
  return rig;
}

namespace {

Rig read_device_file(const std::string& path) {
  std::stringstream text;
  if (!(text << std::ifstream(path).rdbuf())) {
    throw InputError("no calibration file", path, "add it, or give one with --calib");
  }
  const std::string all = text.str();  // a fault names a part of it
  Rig rig;
  if (const ConfigFault fault = read_calibration(all, rig.calibration)) {
    Text<512> line;
    put_fault(line, path.c_str(), fault);
    throw InputError("not a calibration", line.c_str(), "repair the calibration");
  }
  for (TimeNs& shift : rig.shift_ns) shift = rig.calibration.camera_time_offset_ns;
  return rig;
}

}  // namespace

Rig read_rig(const std::string& path, const RigOptions& options, InputLog& log) {
  if (fs::path(path).extension() == ".cfg") {
    Rig rig = read_device_file(path);
    if (options.mono) rig.calibration.cameras = 1;
    if (!options.imu.empty()) set_noise(std::nullopt, std::nullopt, path, options, rig, log);
    return rig;
  }
  return make_rig(read_rig_file(path), path, options, log);
}

Rig make_rig(const RigFile& file, const std::string& path, const RigOptions& options,
             InputLog& log) {
  Rig rig;
  choose(options, file.cameras.size(), path, rig);
  for (const std::string& note : file.notes) log.note(note);
  set_noise(file.imu, file.usual, path, options, rig, log);
  std::pair<int, int> size;
  const bool sizes = file.resizes || file.cameras[0].sizes.size() > 1;
  if (sizes && options.image_size) size = options.image_size();
  for (int c = 0; c < rig.calibration.cameras; ++c) {
    RigCamera read = file.cameras[size_t(rig.camera[c])];
    read.lens = lens_at(file, read, size.first, size.second, path);
    rig.shift_ns[c] = read.shift_ns;
    rig.calibration.camera[c] = camera_of(read, path, log);
  }
  finish(options, rig, log);
  return rig;
}

GnssSensor read_gnss_sensor(const std::string& path) {
  constexpr double kSeconds_max = 10;
  const Document source(path);
  const YAML::Node& root = source.root();
  const auto seconds = [&](const char* key) {
    const double value = source.has(root, key) ? source.get<double>(root, key) : 0;
    if (!(std::abs(value) < kSeconds_max)) source.fail("needs a few seconds at most", key);
    return from_seconds(value);
  };
  GnssSensor out;
  if (source.has(root, "T_BS")) out.antenna.p_BA = source.transform(root, "T_BS").p;
  out.antenna.time_offset_ns = seconds("time_offset");
  out.latency_ns = seconds("latency");
  if (out.latency_ns < 0) source.fail("needs a number not below 0", "latency");
  if (!source.has(root, "truth_world")) return out;
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
  const Document source(path);
  const YAML::Node& root = source.root();
  const auto kind = source.get<std::string>(root, "kind");
  const auto found = std::find(std::begin(kKinds), std::end(kKinds), kind);
  if (found == std::end(kKinds)) {
    source.fail("unknown wheels '" + kind + "' (known: left_right, twist, ticks, steering)",
                "kind");
  }
  const auto length = [&](const char* key, bool needed) {
    if (!source.has(root, key) && !needed) return 0.0;
    const double value = source.get<double>(root, key);
    if (!(value > 0)) source.fail("needs a number above 0", key);
    return value;
  };
  WheelSensor out;
  out.kind = WheelKind(found - std::begin(kKinds));
  WheelCalibration& wheels = out.calibration;
  wheels.known = true;
  wheels.T_BV = source.transform(root, "T_BS");
  wheels.track_m = length("track", false);
  wheels.wheelbase_m = length("wheelbase", out.kind == WheelKind::kSteering);
  if (out.kind == WheelKind::kTicks) {
    wheels.tick_m = 2 * M_PI * length("radius", true) / length("ticks_per_turn", true);
  }
  if (source.has(root, "time_offset")) {
    const double offset_s = source.get<double>(root, "time_offset");
    if (!(std::abs(offset_s) < kSeconds_max)) {
      source.fail("needs a few seconds at most", "time_offset");
    }
    wheels.time_offset_ns = from_seconds(offset_s);
  }
  return out;
}

namespace {

// The number that is out of its band, and which one may have been meant.
void check_noise(const ImuNoise& imu, const std::string& where) {
  for (const ImuBand& band : kImuBands) {
    const double value = imu.*band.field;
    if (value >= band.min && value <= band.max) continue;
    const auto fits = [&](double v) { return v >= band.min && v <= band.max; };
    std::string to_do = band.what_to_do;
    if (value < band.min && fits(std::sqrt(value))) {
      to_do = "it looks like a variance: give its root, " + text_of("%.2g", std::sqrt(value));
    } else if (value > band.max) {
      to_do += ", as the data sheet has them; to trust the IMU less, go up to " +
               text_of("%g", band.max) + "; --imu takes them from another file";
    }
    throw InputError(std::string(band.what) + ", it is " + text_of("%.3g", value) + " " + band.unit,
                     where + ", imu", to_do);
  }
}

}  // namespace

void check_sense(const Calibration& calibration, const std::string& where) {
  const CalibrationFault fault = find_fault(calibration);
  if (!fault) return;
  if (std::string(fault.where) == "imu") check_noise(calibration.imu, where);
  throw InputError(fault.what, where + ", " + fault.where, fault.what_to_do);
}

}  // namespace pirvs::tools
