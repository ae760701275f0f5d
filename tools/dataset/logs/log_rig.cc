#include "tools/dataset/logs/log_rig.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

constexpr const char* kGiveOne =
    "give one with --calib, Kalibr's camchain-imucam.yaml (docs/formats.md)";

// The last part of the image's topic, without what image_transport puts behind it.
bool is_rectified(const std::string& topic) { return topic.find("image_rect") != topic.npos; }

// frame -> frame, along the tree, whichever way its links go.
std::optional<SE3> transform_between(const std::vector<RosTransform>& all, const std::string& from,
                                     const std::string& to) {
  std::map<std::string, SE3> reached;  // T from `from`
  reached[from] = SE3{};
  for (bool grown = true; grown && reached.count(to) == 0;) {
    grown = false;
    for (const RosTransform& link : all) {
      const auto child = reached.find(link.child), parent = reached.find(link.parent);
      if ((child == reached.end()) == (parent == reached.end())) continue;
      grown = true;
      if (child != reached.end()) {
        reached[link.parent] = link.T * child->second;
      } else {
        reached[link.child] = link.T.inverse() * parent->second;
      }
    }
  }
  const auto found = reached.find(to);
  return found == reached.end() ? std::nullopt : std::optional<SE3>(found->second);
}

YAML::Node list_of(std::initializer_list<double> values) {
  YAML::Node out(YAML::NodeType::Sequence);
  for (const double value : values) out.push_back(value);
  return out;
}

// Where a camera stands, and how it looks, in the coordinates that all rectified images share.
SE3 rectified_pose(const Document& file, const LogCamera& camera) {
  const CameraInfo& info = camera.info;
  SE3 T;
  const bool turned = !is_rectified(camera.topic) && !info.R.isZero(0);
  if (turned) T.R = file.rotation(info.R, "R");
  if (info.P(0, 0) > 0) T.p.x() = -info.P(0, 3) / info.P(0, 0);
  if (info.P(1, 1) > 0) T.p.y() = -info.P(1, 3) / info.P(1, 1);
  return T;
}

// As Kalibr would write it.
YAML::Node lens_of(const Document& file, const LogCamera& camera) {
  const CameraInfo& info = camera.info;
  const bool rectified = is_rectified(camera.topic) && info.P(0, 0) > 0;
  if (!rectified && !(info.K(0, 0) > 0)) {
    file.fail("the camera is not calibrated, its K is zero", "K", kGiveOne);
  }
  const Mat3 K = rectified ? Mat3(info.P.leftCols<3>()) : info.K;
  const double bx = std::max(1u, info.binning_x), by = std::max(1u, info.binning_y);
  const bool whole = info.roi_width == 0 || info.roi_height == 0;
  const double width = (whole ? info.width : info.roi_width) / bx;
  const double height = (whole ? info.height : info.roi_height) / by;
  YAML::Node out;
  out["camera_model"] = "pinhole";
  out["intrinsics"] = list_of(
      {K(0, 0) / bx, K(1, 1) / by, (K(0, 2) - info.roi_x) / bx, (K(1, 2) - info.roi_y) / by});
  const bool zero = std::all_of(info.D.begin(), info.D.end(), [](double k) { return k == 0; });
  out["distortion_model"] = rectified || zero ? "none" : info.distortion_model;
  out["distortion_coeffs"] = YAML::Node(YAML::NodeType::Sequence);
  for (size_t i = 0; !rectified && !zero && i < info.D.size(); ++i) {
    out["distortion_coeffs"].push_back(info.D[i]);
  }
  out["resolution"] = list_of({std::floor(width), std::floor(height)});
  out["rostopic"] = camera.topic;
  return out;
}

YAML::Node matrix_of(const SE3& T) {
  return list_of({T.R(0, 0), T.R(0, 1), T.R(0, 2), T.p.x(), T.R(1, 0), T.R(1, 1), T.R(1, 2),
                  T.p.y(), T.R(2, 0), T.R(2, 1), T.R(2, 2), T.p.z()});
}

}  // namespace

std::string info_topic_of(const std::string& image_topic) {
  constexpr const char* kCompressed = "/compressed";
  std::string base = image_topic;
  if (const size_t at = base.rfind(kCompressed); at != std::string::npos) base.resize(at);
  const size_t slash = base.rfind('/');
  return (slash == std::string::npos ? "" : base.substr(0, slash)) + "/camera_info";
}

RigFile rig_of_log(const std::string& path, const std::vector<LogCamera>& cameras,
                   const std::string& imu_frame, const std::vector<RosTransform>& transforms) {
  YAML::Node chain;
  SE3 T_BC0, T_RC0;  // R: the rectified coordinates
  for (size_t c = 0; c < cameras.size(); ++c) {
    const LogCamera& camera = cameras[c];
    const Document file(path + ", " + camera.info_topic, YAML::Node());
    SE3 T_RC = rectified_pose(file, camera);
    const auto by_tf = transform_between(transforms, camera.frame_id, imu_frame);
    if (c == 0 && !by_tf) {
      file.fail("the log has lenses but not where the IMU is: no transform from '" +
                    camera.frame_id + "' to '" + imu_frame + "'",
                "/tf_static", "record /tf_static, or " + std::string(kGiveOne));
    }
    // Transforms have the raw camera, also where its images are rectified.
    const bool turned = is_rectified(camera.topic) && !camera.info.R.isZero(0);
    const SE3 T_raw =
        turned ? SE3{file.rotation(camera.info.R, "R").transpose(), {0, 0, 0}} : SE3{};
    SE3 T_BC = by_tf ? *by_tf * T_raw : SE3{};
    if (c == 0) {
      T_BC0 = T_BC;
      T_RC0 = T_RC;
    } else if ((T_RC.p - T_RC0.p).norm() > 0) {
      T_BC = T_BC0 * T_RC0.inverse() * T_RC;
    } else if (!by_tf || (T_BC.p - T_BC0.p).norm() == 0) {
      file.fail("no baseline: P[3] of the right camera is that of the left one", "P",
                "run the left one alone with --mono, or " + std::string(kGiveOne));
    }
    YAML::Node node = lens_of(file, camera);
    node["T_imu_cam"] = matrix_of(T_BC);
    chain["cam" + std::to_string(c)] = node;
  }
  RigFile out = read_kalibr(Document(path + ", CameraInfo", chain));
  out.notes.push_back("calibration: the log's own CameraInfo, and its transform from '" +
                      cameras[0].frame_id + "' to the IMU's '" + imu_frame + "'");
  return out;
}

}  // namespace pirvs::tools
