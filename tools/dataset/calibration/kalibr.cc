// Kalibr's camchain and what OpenVINS makes of it.
// Source  Kalibr wiki, "YAML formats"; OpenVINS, "Sensor Calibration".
#include <algorithm>

#include "tools/dataset/calibration/rig_file.h"

namespace pirvs::tools {
namespace {

Lens lens_of(const Document& file, const YAML::Node& camera) {
  Lens lens;
  const auto size = file.numbers(camera, "resolution", 2);
  set_size(file, size[0], size[1], "resolution", lens);
  const auto model = file.get<std::string>(camera, "camera_model");
  std::vector<double> k = file.numbers(camera, "intrinsics");
  size_t first = 0;
  if (model == "omni") {
    lens.projection = Projection::kOmni;
    first = 1;
  } else if (model == "ds") {
    lens.projection = Projection::kDoubleSphere;
    first = 2;
  } else if (model == "eucm") {
    lens.projection = Projection::kEucm;
    first = 2;
  } else if (model != "pinhole") {
    file.fail("unknown model '" + model + "' (known: pinhole, omni, ds, eucm)", "camera_model",
              "calibrate again with pinhole-equi (fisheye) or pinhole-radtan, the file cannot be "
              "repaired");
  }
  k = file.numbers(camera, "intrinsics", 4 + first);
  if (first > 0) lens.a = k[0];
  if (first > 1) lens.b = k[1];
  k.erase(k.begin(), k.begin() + std::ptrdiff_t(first));
  set_intrinsics(file, k, "intrinsics", lens);
  const auto d = file.has(camera, "distortion_coeffs") ? file.numbers(camera, "distortion_coeffs")
                                                       : std::vector<double>();
  const auto distortion = file.get<std::string>(camera, "distortion_model");
  set_distortion(file, distortion, "distortion_model", d, "distortion_coeffs", lens);
  return lens;
}

}  // namespace

RigFile read_kalibr(const Document& file) {
  constexpr int kCamerasMax = 16;
  RigFile out;
  out.imu = noise_of(file);
  SE3 T_CB_before;
  for (int c = 0; c < kCamerasMax; ++c) {
    const std::string name = "cam" + std::to_string(c);
    const YAML::Node camera = file.root()[name];
    if (!camera) break;
    if (!camera.IsMap()) file.fail("missing value", name);
    SE3 T_CB;
    if (file.has(camera, "T_cam_imu")) {
      T_CB = file.transform(camera, "T_cam_imu");
    } else if (file.has(camera, "T_imu_cam")) {
      T_CB = file.transform(camera, "T_imu_cam").inverse();
    } else if (c > 0) {
      T_CB = file.transform(camera, "T_cn_cnm1") * T_CB_before;
    } else {
      file.fail("missing value (camchain-imucam.yaml has it)", "T_cam_imu",
                "give Kalibr's camchain-imucam.yaml, of kalibr_calibrate_imu_camera");
    }
    T_CB_before = T_CB;
    const bool given = file.has(camera, "T_imu_cam") && !file.has(camera, "T_cam_imu");
    RigCamera read;
    read.name = name;
    if (file.has(camera, "rostopic")) read.topic = file.get<std::string>(camera, "rostopic");
    read.lens = lens_of(file, camera);
    read.T_BC = given ? file.transform(camera, "T_imu_cam") : T_CB.inverse();
    read.shift_ns = shift_ns(file, camera, "timeshift_cam_imu");
    out.cameras.push_back(read);
  }
  if (out.cameras.empty()) file.fail("missing value", "cam0");
  return out;
}

RigFile read_openvins(const Document& file) {
  const auto chain = file.get<std::string>(file.root(), "relative_config_imucam");
  RigFile out = read_kalibr(Document(file.beside(chain)));
  if (file.has(file.root(), "relative_config_imu")) {
    const auto imu = file.get<std::string>(file.root(), "relative_config_imu");
    out.imu = noise_of(Document(file.beside(imu)));
  }
  // How many of them the estimator uses.
  if (file.has(file.root(), "max_cameras")) {
    const double used = file.positive(file.root(), "max_cameras");
    if (used < double(out.cameras.size())) out.cameras.resize(size_t(std::max(1.0, used)));
  }
  return out;
}

}  // namespace pirvs::tools
