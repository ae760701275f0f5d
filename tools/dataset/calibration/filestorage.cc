// ORB-SLAM3 and VINS: yaml of OpenCV's FileStorage.
// Source  ORB-SLAM3, Examples/*.yaml (File.version 1.0); VINS-Fusion, config/*.yaml; camodocal.
#include <cmath>

#include "tools/dataset/calibration/rig_file.h"

namespace pirvs::tools {
namespace {

std::vector<double> some(const Document& file, const YAML::Node& node, const std::string& prefix,
                         std::initializer_list<const char*> names) {
  std::vector<double> out;
  for (const char* name : names) out.push_back(file.number(node, (prefix + name).c_str(), 0));
  return out;
}

std::vector<double> all(const Document& file, const YAML::Node& node, const std::string& prefix,
                        std::initializer_list<const char*> names) {
  std::vector<double> out;
  for (const char* name : names) out.push_back(file.number(node, (prefix + name).c_str()));
  return out;
}

Lens orbslam_lens(const Document& file, const std::string& prefix, const std::string& type) {
  Lens lens;
  const YAML::Node& root = file.root();
  set_size(file, file.number(root, "Camera.width"), file.number(root, "Camera.height"),
           "Camera.width", lens);
  set_intrinsics(file, all(file, root, prefix, {"fx", "fy", "cx", "cy"}), (prefix + "fx").c_str(),
                 lens);
  const std::string key = prefix + "k1";
  if (type == "KannalaBrandt8") {
    set_distortion(file, "equi", "Camera.type", all(file, root, prefix, {"k1", "k2", "k3", "k4"}),
                   key.c_str(), lens);
  } else if (type == "PinHole" || type == "Pinhole") {
    set_distortion(file, "radtan", "Camera.type",
                   some(file, root, prefix, {"k1", "k2", "p1", "p2", "k3"}), key.c_str(), lens);
  } else if (type != "Rectified") {
    file.fail("unknown model '" + type + "' (known: PinHole, KannalaBrandt8, Rectified)",
              "Camera.type");
  }
  return lens;
}

// A camera of camodocal, in a file of its own or within VINS-Mono's.
Lens camodocal_lens(const Document& file) {
  Lens lens;
  const YAML::Node& root = file.root();
  set_size(file, file.number(root, "image_width"), file.number(root, "image_height"), "image_width",
           lens);
  const auto model = file.get<std::string>(root, "model_type");
  const YAML::Node k = root["projection_parameters"], d = root["distortion_parameters"];
  const YAML::Node mirror = root["mirror_parameters"];
  if (!k) file.fail("missing value", "projection_parameters");
  if (model == "KANNALA_BRANDT") {
    set_intrinsics(file, all(file, k, "", {"mu", "mv", "u0", "v0"}), "projection_parameters", lens);
    set_distortion(file, "equi", "model_type", all(file, k, "", {"k2", "k3", "k4", "k5"}),
                   "projection_parameters", lens);
    return lens;
  }
  if (model == "MEI") {
    if (!mirror) file.fail("missing value", "mirror_parameters");
    lens.projection = Projection::kOmni;
    lens.a = file.number(mirror, "xi");
    set_intrinsics(file, all(file, k, "", {"gamma1", "gamma2", "u0", "v0"}),
                   "projection_parameters", lens);
  } else if (model == "PINHOLE") {
    set_intrinsics(file, all(file, k, "", {"fx", "fy", "cx", "cy"}), "projection_parameters", lens);
  } else {
    file.fail("unknown model '" + model + "' (known: PINHOLE, MEI, KANNALA_BRANDT)", "model_type",
              "calibrate again with one of these");
  }
  if (d) {
    set_distortion(file, "radtan", "model_type", some(file, d, "", {"k1", "k2", "p1", "p2"}),
                   "distortion_parameters", lens);
  }
  return lens;
}

}  // namespace

RigFile read_orbslam(const Document& file) {
  const YAML::Node& root = file.root();
  const auto type = file.get<std::string>(root, "Camera.type");
  if (!file.has(root, "Camera1.fx")) {
    file.fail("a file of ORB-SLAM3 before 1.0 or of ORB-SLAM2", "Camera1.fx",
              "give the one with File.version 1.0, of the same folder of ORB-SLAM3");
  }
  RigFile out;
  out.imu = noise_of(file);
  const char* const pose = file.has(root, "IMU.T_b_c1") ? "IMU.T_b_c1" : "Tbc";
  RigCamera left;
  left.name = "Camera1";
  left.lens = orbslam_lens(file, "Camera1.", type);
  left.T_BC = file.transform(root, pose);
  left.shift_ns = shift_ns(file, root, "timeshift_cam_imu");
  out.cameras.push_back(left);
  const bool rectified = type == "Rectified" && file.has(root, "Stereo.b");
  if (!file.has(root, "Stereo.T_c1_c2") && !rectified) return out;
  RigCamera right = left;
  right.name = "Camera2";
  if (type != "Rectified") right.lens = orbslam_lens(file, "Camera2.", type);
  SE3 T_C0C1;
  if (file.has(root, "Stereo.T_c1_c2")) {
    T_C0C1 = file.transform(root, "Stereo.T_c1_c2");
  } else {
    T_C0C1.p.x() = file.positive(root, "Stereo.b");
  }
  right.T_BC = left.T_BC * T_C0C1;
  out.cameras.push_back(right);
  return out;
}

RigFile read_vins(const Document& file) {
  const YAML::Node& root = file.root();
  RigFile out;
  out.imu = noise_of(file);
  const TimeNs shift = shift_ns(file, root, "td");  // t_imu = t_camera + td
  if (file.has(root, "extrinsicRotation")) {        // VINS-Mono: one camera, all in one file
    RigCamera camera;
    camera.name = "cam0";
    camera.lens = camodocal_lens(file);
    const auto R = file.numbers(root, "extrinsicRotation", 9);
    const auto p = file.numbers(root, "extrinsicTranslation", 3);
    for (int i = 0; i < 9; ++i) camera.T_BC.R(i / 3, i % 3) = R[size_t(i)];
    camera.T_BC.R = file.rotation(camera.T_BC.R, "extrinsicRotation");
    camera.T_BC.p = Vec3(p[0], p[1], p[2]);
    camera.shift_ns = shift;
    out.cameras.push_back(camera);
    return out;
  }
  for (int c = 0; c < 2; ++c) {
    const std::string n = std::to_string(c);
    const std::string pose = "body_T_cam" + n, calib = "cam" + n + "_calib";
    if (!file.has(root, pose.c_str())) break;
    RigCamera camera;
    camera.name = "cam" + n;
    if (!file.has(root, calib.c_str()) && file.has(root, "model_type")) {
      camera.lens = camodocal_lens(file);
    } else {
      camera.lens =
          camodocal_lens(Document(file.beside(file.get<std::string>(root, calib.c_str()))));
    }
    camera.T_BC = file.transform(root, pose.c_str());
    camera.shift_ns = shift;
    out.cameras.push_back(camera);
  }
  return out;
}

}  // namespace pirvs::tools
