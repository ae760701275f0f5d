#include "tools/dataset/calibration/rig_file.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr const char* kAgain =
    "calibrate again with pinhole-equi (fisheye) or pinhole-radtan, the file cannot be repaired";

struct Family {
  const char* keys[2];  // one of them is there
  RigFile (*read)(const Document&);
};
constexpr Family kFamilies[] = {
    {{"relative_config_imucam", "relative_config_imu"}, read_openvins},
    {{"value0", nullptr}, read_basalt},
    {{"Camera.type", "Camera1.fx"}, read_orbslam},
    {{"body_T_cam0", "extrinsicRotation"}, read_vins},
    {{"cameras", nullptr}, read_okvis},
    {{"cameraData", nullptr}, read_depthai},
    {{"cam0", "cam1"}, read_kalibr},
};

struct NoiseKeys {
  const char *gyro, *gyro_walk, *accel, *accel_walk;
  const char* rates[2];
};
constexpr NoiseKeys kNoiseKeys[] = {
    {"gyroscope_noise_density",
     "gyroscope_random_walk",
     "accelerometer_noise_density",
     "accelerometer_random_walk",
     {"update_rate", "rate_hz"}},
    {"gyr_n", "gyr_w", "acc_n", "acc_w", {"imu_rate", nullptr}},
    {"sigma_g_c", "sigma_gw_c", "sigma_a_c", "sigma_aw_c", {"imu_rate", nullptr}},
    {"IMU.NoiseGyro", "IMU.GyroWalk", "IMU.NoiseAcc", "IMU.AccWalk", {"IMU.Frequency", nullptr}},
    {"gyro_noise_std",
     "gyro_bias_std",
     "accel_noise_std",
     "accel_bias_std",
     {"imu_update_rate", nullptr}},
};

// Where a file keeps its IMU.
constexpr const char* kNoiseNodes[] = {"imu0", "imu_params", "imu_parameters", "imu", "value0"};

// One number, or one for each axis: then the largest.
double density(const Document& file, const YAML::Node& node, const char* key) {
  const auto values = file.numbers(node, key);
  if (values.empty() || values.size() > 3) file.fail("needs one number", key);
  const double value = *std::max_element(values.begin(), values.end());
  if (!(value > 0)) file.fail("needs a number above 0", key);
  return value;
}

Mat3 matrix_of(const Document& file, const YAML::Node& node, const char* key) {
  Mat3 out = Mat3::Identity();
  if (!file.has(node, key)) return out;
  const auto m = file.numbers(node, key, 9);
  for (int i = 0; i < 9; ++i) out(i / 3, i % 3) = m[size_t(i)];
  return out;
}

Vec3 bias_of(const Document& file, const YAML::Node& node, const char* key) {
  if (!file.has(node, key)) return Vec3::Zero();
  const auto b = file.numbers(node, key, 3);
  return {b[0], b[1], b[2]};
}

std::optional<RigNoise> noise_in(const Document& file, const YAML::Node& node,
                                 const std::string& where) {
  for (const NoiseKeys& keys : kNoiseKeys) {
    if (!file.has(node, keys.gyro)) continue;
    RigNoise out;
    out.from = file.path() + where;
    out.noise.gyro_noise = density(file, node, keys.gyro);
    out.noise.gyro_walk = density(file, node, keys.gyro_walk);
    out.noise.accel_noise = density(file, node, keys.accel);
    out.noise.accel_walk = density(file, node, keys.accel_walk);
    out.intrinsics = {
        matrix_of(file, node, "gyroscope_matrix"), matrix_of(file, node, "accelerometer_matrix"),
        bias_of(file, node, "gyroscope_bias"), bias_of(file, node, "accelerometer_bias")};
    for (const char* rate : keys.rates) {
      if (rate == nullptr || !file.has(node, rate) || out.has_rate) continue;
      out.noise.rate_hz = file.positive(node, rate);
      out.has_rate = true;
    }
    return out;
  }
  return std::nullopt;
}

bool is_one_of(std::string_view text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return text == word; });
}

}  // namespace

std::optional<RigNoise> noise_of(const Document& file) {
  if (const auto found = noise_in(file, file.root(), "")) return found;
  for (const char* name : kNoiseNodes) {
    if (!file.has(file.root(), name)) continue;
    if (const auto found = noise_in(file, file.root()[name], std::string(", ") + name)) {
      return found;
    }
  }
  return std::nullopt;
}

std::optional<RigNoise> find_noise(const std::string& path) {
  if (is_realsense(path)) return std::nullopt;
  const Document file(path);
  if (file.has(file.root(), "relative_config_imu")) return read_openvins(file).imu;
  return noise_of(file);
}

RigFile read_rig_file(const std::string& path) {
  if (is_realsense(path)) return read_realsense(path);
  const Document file(path);
  for (const Family& family : kFamilies) {
    for (const char* key : family.keys) {
      if (key == nullptr || !file.has(file.root(), key)) continue;
      RigFile out = family.read(file);
      if (out.cameras.empty()) file.fail("no camera", key);
      return out;
    }
  }
  file.fail(
      "not a calibration that is known here (Kalibr, OpenVINS, Basalt, ORB-SLAM3 1.0, VINS-Fusion, "
      "OKVIS2, DepthAI, RealSense, a device's .cfg)",
      "missing value: cam0", "give one of these, or write Kalibr's camchain (docs/formats.md)");
}

namespace {

// Scaled so that it fills the images, the rest cropped evenly, as DepthAI does.
Lens resized(const Lens& lens, int width, int height) {
  Lens out = lens;
  const double scale = std::max(double(width) / lens.width, double(height) / lens.height);
  const auto centre = [&](double c, int from, int to) {  // (0, 0) is a pixel's centre
    return (c + 0.5) * scale - 0.5 - (from * scale - to) / 2;
  };
  out.width = width;
  out.height = height;
  out.fx *= scale;
  out.fy *= scale;
  out.cx = centre(lens.cx, lens.width, width);
  out.cy = centre(lens.cy, lens.height, height);
  return out;
}

}  // namespace

Lens lens_at(const RigFile& rig, const RigCamera& camera, int width, int height,
             const std::string& path) {
  const bool known = width > 0 && height > 0;
  if (rig.resizes && known && (width > height) == (camera.lens.width > camera.lens.height)) {
    return resized(camera.lens, width, height);
  }
  if (camera.sizes.size() < 2) return camera.lens;
  std::string all;
  for (const Lens& lens : camera.sizes) {
    if (lens.width == width && lens.height == height) return lens;
    all += (all.empty() ? "" : ", ") + std::to_string(lens.width) + " x " +
           std::to_string(lens.height);
  }
  const std::string asked = std::to_string(width) + " x " + std::to_string(height);
  const bool turned = std::any_of(camera.sizes.begin(), camera.sizes.end(), [&](const Lens& lens) {
    return lens.width == height && lens.height == width;
  });
  throw InputError(
      known ? "no lens for images of " + asked : "it has lenses for images of several sizes",
      path + ", " + camera.name + " (" + all + ")",
      turned  ? "width and height are exchanged: give the calibration of the images as they are"
      : known ? "give the calibration of this recording with --calib"
              : "say which to `pirvs calibration` with --size, as 848x480");
}

RigNoise small_imu(const char* whose) {
  // BMI055, BMI270: 0.014 and 0.007 deg/s/sqrt(Hz), 150 and 160 ug/sqrt(Hz) by their data sheets,
  // of which the larger one times two; the walks as TUM-VI gives them for a BMI160.
  RigNoise out;
  out.noise.gyro_noise = 4.9e-4;
  out.noise.gyro_walk = 2.2e-5;
  out.noise.accel_noise = 3.1e-3;
  out.noise.accel_walk = 8.6e-4;
  out.from = std::string("the data sheet, ") + whose + " times two, as the file has none (--imu)";
  return out;
}

std::vector<std::string> rig_topics(const std::string& path) {
  std::vector<std::string> out;
  if (path.size() > 4 && path.substr(path.size() - 4) == ".cfg") return out;
  for (const RigCamera& camera : read_rig_file(path).cameras) out.push_back(camera.topic);
  return out;
}

void set_size(const Document& file, double width, double height, const char* key, Lens& lens) {
  constexpr double kMin = 16, kMax = 65'536;
  if (!(width >= kMin && width <= kMax && height >= kMin && height <= kMax)) {
    file.fail("needs width and height", key);
  }
  lens.width = int(width);
  lens.height = int(height);
}

void set_intrinsics(const Document& file, const std::vector<double>& k, const char* key,
                    Lens& lens) {
  if (!(k[0] > 0 && k[1] > 0)) file.fail("the focal length is not positive", key);
  lens.fx = k[0];
  lens.fy = k[1];
  lens.cx = k[2];
  lens.cy = k[3];
}

void set_distortion(const Document& file, const std::string& model, const char* model_key,
                    const std::vector<double>& d, const char* key, Lens& lens) {
  const bool zero = std::all_of(d.begin(), d.end(), [](double k) { return k == 0; });
  const auto need = [&](bool good, const char* what) {
    if (!good) file.fail(std::string(what) + ", has " + std::to_string(d.size()), key);
  };
  if (is_one_of(model, {"none", "NONE", "pinhole", "undistorted"})) {
    need(zero, "the model has no distortion and takes no numbers but 0");
  } else if (is_one_of(model, {"radtan", "radial-tangential", "radialtangential", "plumb_bob",
                               "radtan8", "radialtangential8", "rational_polynomial", "radtan5"})) {
    need(d.empty() || d.size() == 4 || d.size() == 5 || d.size() == 8 || d.size() == 12 ||
             d.size() == 14,
         "needs 0, 4, 5, 8, 12 or 14 numbers");
    lens.distortion = zero ? Distortion::kNone : Distortion::kRadtan;
    std::copy_n(d.begin(), std::min(d.size(), lens.d.size()), lens.d.begin());
  } else if (is_one_of(model, {"equidistant", "equi", "equidist", "fisheye", "kannala_brandt"})) {
    need(d.size() == 4, "needs 4 numbers");
    lens.distortion = Distortion::kEquidistant;
    std::copy(d.begin(), d.end(), lens.d.begin());
  } else if (is_one_of(model, {"fov", "FOV"})) {
    need(d.size() == 1, "needs 1 number");
    if (!(d[0] > 0 && d[0] < M_PI)) file.fail("needs an angle between 0 and pi", key);
    lens.distortion = Distortion::kFov;
    lens.d[0] = d[0];
  } else {
    file.fail("unknown model '" + model + "' (known: none, radtan, equidistant, fov)", model_key,
              kAgain);
  }
}

TimeNs shift_ns(const Document& file, const YAML::Node& node, const char* key) {
  constexpr double kOffset_s_max = 1e6;
  if (!file.has(node, key)) return 0;
  const auto shift_s = file.get<double>(node, key);
  if (!(std::abs(shift_s) < kOffset_s_max)) file.fail("needs a number of seconds", key);
  return from_seconds(shift_s);
}

RigCamera read_asl_sensor(const Document& file) {
  RigCamera out;
  const YAML::Node& root = file.root();
  const auto size = file.numbers(root, "resolution", 2);
  set_size(file, size[0], size[1], "resolution", out.lens);
  const auto projection = file.get<std::string>(root, "camera_model");
  if (projection != "pinhole") {
    file.fail("unknown model '" + projection + "'", "camera_model", kAgain);
  }
  set_intrinsics(file, file.numbers(root, "intrinsics", 4), "intrinsics", out.lens);
  set_distortion(file, file.get<std::string>(root, "distortion_model"), "distortion_model",
                 file.numbers(root, "distortion_coefficients"), "distortion_coefficients",
                 out.lens);
  out.T_BC = file.transform(root, "T_BS");
  out.shift_ns = shift_ns(file, root, "timeshift_cam_imu");
  return out;
}

}  // namespace pirvs::tools
