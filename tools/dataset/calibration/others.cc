// Basalt, OKVIS and DepthAI: cameras stand in a list.
// Source  Basalt, doc/Calibration.md and data/*.json; OKVIS2, config/*.yaml; DepthAI, EepromData.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tools/dataset/calibration/rig_file.h"

namespace pirvs::tools {
namespace {

SE3 basalt_pose(const Document& file, const YAML::Node& node) {
  SE3 T;
  const Eigen::Quaterniond q(file.number(node, "qw"), file.number(node, "qx"),
                             file.number(node, "qy"), file.number(node, "qz"));
  if (!(std::abs(q.norm() - 1) < 1e-2)) file.fail("the quaternion is not a unit one", "T_imu_cam");
  T.R = q.normalized().toRotationMatrix();
  T.p = Vec3(file.number(node, "px"), file.number(node, "py"), file.number(node, "pz"));
  return T;
}

Lens basalt_lens(const Document& file, const YAML::Node& node) {
  Lens lens;
  const auto type = file.get<std::string>(node, "camera_type");
  const YAML::Node k = node["intrinsics"];
  if (!k) file.fail("missing value", "intrinsics");
  set_intrinsics(
      file,
      {file.number(k, "fx"), file.number(k, "fy"), file.number(k, "cx"), file.number(k, "cy")},
      "intrinsics", lens);
  const auto d = [&](std::initializer_list<const char*> names) {
    std::vector<double> out;
    for (const char* name : names) out.push_back(file.number(k, name, 0));
    return out;
  };
  if (type == "ds") {
    lens.projection = Projection::kDoubleSphere;
    lens.a = file.number(k, "xi");
    lens.b = file.number(k, "alpha");
  } else if (type == "eucm") {
    lens.projection = Projection::kEucm;
    lens.a = file.number(k, "alpha");
    lens.b = file.number(k, "beta");
  } else if (type == "ucm") {  // EUCM with beta = 1
    lens.projection = Projection::kEucm;
    lens.a = file.number(k, "alpha");
    lens.b = 1;
  } else if (type == "kb4") {
    set_distortion(file, "equi", "camera_type", d({"k1", "k2", "k3", "k4"}), "intrinsics", lens);
  } else if (type == "pinhole-radtan8") {
    set_distortion(file, "radtan8", "camera_type",
                   d({"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}), "intrinsics", lens);
  } else if (type != "pinhole") {
    file.fail("unknown model '" + type + "' (known: pinhole, pinhole-radtan8, kb4, ds, eucm, ucm)",
              "camera_type", "calibrate again with --cam-types kb4");
  }
  return lens;
}

const YAML::Node list(const Document& file, const YAML::Node& node, const char* key) {
  if (!file.has(node, key) || !node[key].IsSequence()) file.fail("needs a list", key);
  return node[key];
}

SE3 depthai_extrinsics(const Document& file, const YAML::Node& node, const char* key) {
  const auto m = file.numbers(node, "rotationMatrix");
  const bool empty = std::all_of(m.begin(), m.end(), [](double v) { return v == 0; });
  if (m.size() != 9 || empty) {
    file.fail("the device has no extrinsics here", key,
              "calibrate cameras against the IMU with Kalibr (docs/sensors.md)");
  }
  constexpr double kCm = 0.01;
  Mat3 R;
  for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = m[size_t(i)];
  const auto place = [&](const char* name) {
    const YAML::Node t = node[name];
    if (!t) return Vec3(Vec3::Zero());
    return Vec3(kCm * Vec3(file.number(t, "x"), file.number(t, "y"), file.number(t, "z")));
  };
  SE3 out;
  out.R = file.rotation(R, key);
  out.p = place("translation");
  if (out.p.norm() == 0) out.p = place("specTranslation");
  return out;
}

constexpr double kDepthaiUnset = 64;  // -1, or that in a byte

struct DepthaiCamera {
  int socket = 0;
  YAML::Node data;
};

// Along the links that each camera has to another: the last one's socket, and T from here to there.
struct DepthaiEnd {
  int socket = 0;
  SE3 T;
};

DepthaiEnd depthai_end(const Document& file, const std::vector<DepthaiCamera>& all, int from) {
  DepthaiEnd out{from, {}};
  for (size_t steps = 0; steps <= all.size(); ++steps) {
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const DepthaiCamera& c) { return c.socket == out.socket; });
    if (found == all.end()) break;
    const YAML::Node link = found->data["extrinsics"];
    if (!link) file.fail("missing value", "extrinsics");
    const double next = file.number(link, "toCameraSocket", -1);
    if (next < 0) return out;
    if (next >= kDepthaiUnset) return out;
    out.T = depthai_extrinsics(file, link, "extrinsics") * out.T;
    out.socket = int(next);
  }
  file.fail("the cameras are not linked to each other", "extrinsics",
            "calibrate with Kalibr (docs/sensors.md)");
}

SE3 depthai_transform(const Document& file, const std::vector<DepthaiCamera>& all, int from,
                      int to) {
  const DepthaiEnd a = depthai_end(file, all, from), b = depthai_end(file, all, to);
  if (a.socket != b.socket) {
    file.fail("the cameras are not linked to each other", "extrinsics",
              "calibrate with Kalibr (docs/sensors.md)");
  }
  return b.T.inverse() * a.T;
}

Lens depthai_lens(const Document& file, const YAML::Node& data) {
  Lens lens;
  set_size(file, file.number(data, "width"), file.number(data, "height"), "width", lens);
  const auto K = file.numbers(data, "intrinsicMatrix", 9);
  set_intrinsics(file, {K[0], K[4], K[2], K[5]}, "intrinsicMatrix", lens);
  auto d = file.numbers(data, "distortionCoeff");
  constexpr double kPerspective = 0, kFisheye = 1;
  const double type = file.number(data, "cameraType", kPerspective);
  if (type != kPerspective && type != kFisheye) {
    file.fail("unknown camera type (known: 0, perspective, and 1, fisheye)", "cameraType",
              "calibrate with Kalibr (docs/sensors.md)");
  }
  const bool fisheye = type == kFisheye;
  if (fisheye) d.resize(4);
  set_distortion(file, fisheye ? "equi" : "radtan", "cameraType", d, "distortionCoeff", lens);
  return lens;
}

}  // namespace

RigFile read_basalt(const Document& file) {
  const YAML::Node root = file.root()["value0"];
  const YAML::Node poses = list(file, root, "T_imu_cam");
  const YAML::Node lenses = list(file, root, "intrinsics");
  const YAML::Node sizes = list(file, root, "resolution");
  if (lenses.size() != poses.size() || sizes.size() != poses.size()) {
    file.fail("not as many cameras as in T_imu_cam", "intrinsics, resolution");
  }
  RigFile out;
  out.imu = noise_of(file);
  for (size_t c = 0; c < poses.size(); ++c) {
    RigCamera camera;
    camera.name = "cam" + std::to_string(c);
    camera.lens = basalt_lens(file, lenses[c]);
    YAML::Node size;
    size["resolution"] = sizes[c];
    const auto pixels = file.numbers(size, "resolution", 2);
    set_size(file, pixels[0], pixels[1], "resolution", camera.lens);
    camera.T_BC = basalt_pose(file, poses[c]);
    // t_imu = t_camera + offset, in ns.
    const double offset = file.number(root, "cam_time_offset_ns", 0);
    if (!(std::abs(offset) < 1e15)) file.fail("needs nanoseconds", "cam_time_offset_ns");
    camera.shift_ns = TimeNs(offset);
    out.cameras.push_back(camera);
  }
  return out;
}

RigFile read_okvis(const Document& file) {
  RigFile out;
  out.imu = noise_of(file);
  TimeNs delay = 0;
  for (const char* name : {"camera_parameters", "camera_params"}) {
    const YAML::Node node = file.root()[name];
    if (node && node.IsMap()) delay = shift_ns(file, node, "image_delay");
  }
  SE3 T_BS;  // OKVIS's body is nearly always its IMU; where not, ours is the IMU
  for (const char* name : {"imu_parameters", "imu_params"}) {
    const YAML::Node node = file.root()[name];
    if (node && node.IsMap() && file.has(node, "T_BS")) T_BS = file.transform(node, "T_BS");
  }
  for (const YAML::Node& node : list(file, file.root(), "cameras")) {
    RigCamera camera;
    camera.name = "cam" + std::to_string(out.cameras.size());
    const auto size = file.numbers(node, "image_dimension", 2);
    set_size(file, size[0], size[1], "image_dimension", camera.lens);
    const auto f = file.numbers(node, "focal_length", 2);
    const auto c = file.numbers(node, "principal_point", 2);
    set_intrinsics(file, {f[0], f[1], c[0], c[1]}, "focal_length", camera.lens);
    set_distortion(file, file.get<std::string>(node, "distortion_type"), "distortion_type",
                   file.numbers(node, "distortion_coefficients"), "distortion_coefficients",
                   camera.lens);
    camera.T_BC = T_BS.inverse() * file.transform(node, "T_SC");
    camera.shift_ns = -delay;  // t_imu = t_camera - image_delay
    out.cameras.push_back(camera);
  }
  return out;
}

RigFile read_depthai(const Document& file) {
  std::vector<DepthaiCamera> all;
  for (const YAML::Node& pair : list(file, file.root(), "cameraData")) {
    if (!pair.IsSequence() || pair.size() != 2 || !pair[1].IsMap()) {
      file.fail("needs pairs of a socket and a camera", "cameraData");
    }
    YAML::Node socket;
    socket["socket"] = pair[0];
    all.push_back({int(file.number(socket, "socket")), pair[1]});
  }
  const YAML::Node pair = file.root()["stereoRectificationData"];
  const bool known = pair && pair.IsMap();
  const auto socket_of = [&](const char* key, double usual) {
    const double socket = known ? file.number(pair, key, usual) : usual;
    return socket < 0 || socket >= kDepthaiUnset ? usual : socket;
  };
  const double sockets[2] = {socket_of("leftCameraSocket", 1), socket_of("rightCameraSocket", 2)};
  const YAML::Node imu = file.root()["imuExtrinsics"];
  if (!imu) file.fail("missing value", "imuExtrinsics");
  const double at = file.number(imu, "toCameraSocket", -1);
  if (!(at >= 0 && at < kDepthaiUnset)) {
    file.fail("the device has no extrinsics here", "imuExtrinsics",
              "calibrate cameras against the IMU with Kalibr (docs/sensors.md)");
  }
  const SE3 T_KB = depthai_extrinsics(file, imu, "imuExtrinsics");  // K: the camera at that socket
  RigFile out;
  for (const double socket : sockets) {
    const auto found = std::find_if(
        all.begin(), all.end(), [&](const DepthaiCamera& c) { return double(c.socket) == socket; });
    if (found == all.end()) {
      file.fail("no camera at the stereo pair's socket " + std::to_string(int(socket)),
                "cameraData", "read the EEPROM again: calibHandler.eepromToJsonFile(FILE)");
    }
    RigCamera camera;
    camera.name = "cam" + std::to_string(out.cameras.size());
    camera.lens = depthai_lens(file, found->data);
    camera.T_BC = T_KB.inverse() * depthai_transform(file, all, found->socket, int(at));
    out.cameras.push_back(camera);
  }
  out.resizes = true;
  out.usual = small_imu("a BMI270's");
  return out;
}

}  // namespace pirvs::tools
