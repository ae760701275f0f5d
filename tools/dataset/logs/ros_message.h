// What    Decodes the messages of ROS that a recording is made of.
// In      Bytes in ROS 1's encoding or in ROS 2's (CDR, little or big endian head, XCDR1).
// Out     What a recording needs of each. t: the header's stamp.
// Frames  as the message has them.
// Units   ns since 1970; rad/s, m/s^2; m.
// Errors  false: cut off, or not what the type says.
// Cost    no copy of pixels.
// Source  sensor_msgs, geometry_msgs, nav_msgs, tf2_msgs; OMG DDS-XTypes 1.3, 7.4 (plain CDR).
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "bsp/api/imu.h"
#include "core/math/se3.h"
#include "tools/dataset/logs/log_file.h"
#include "tools/dataset/trajectory.h"

namespace pirvs::tools {

struct RosHeader {
  TimeNs t = 0;
  std::string frame_id;
};

bool decode_header(Bytes bytes, bool cdr, RosHeader& out);

// sensor_msgs/Imu: its two vectors; what a driver does not measure it fills with zeros.
bool decode_imu(Bytes bytes, bool cdr, ImuSample& out);

// sensor_msgs/Image or CompressedImage, as 8-bit grey.
bool decode_image(Bytes bytes, bool cdr, cv::Mat& grey);
bool decode_compressed_image(Bytes bytes, bool cdr, cv::Mat& grey);
// The file within a CompressedImage; nothing where it is cut off.
Bytes compressed_image(Bytes bytes, bool cdr);

// nav_msgs/Odometry, geometry_msgs/PoseStamped, PoseWithCovarianceStamped, TransformStamped.
bool is_pose(const std::string& type);
bool decode_pose(const std::string& type, Bytes bytes, bool cdr, TrajectoryPose& out);

// sensor_msgs/CameraInfo, as it is.
struct CameraInfo {
  std::string frame_id, distortion_model;
  uint32_t width = 0, height = 0;
  std::vector<double> D;
  Mat3 K = Mat3::Zero(), R = Mat3::Zero();
  Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();
  uint32_t binning_x = 0, binning_y = 0;
  uint32_t roi_x = 0, roi_y = 0, roi_width = 0, roi_height = 0;  // 0: all of it
};
// false also where a number is not finite.
bool decode_camera_info(Bytes bytes, bool cdr, CameraInfo& out);

// Of tf2_msgs/TFMessage, or tf/tfMessage.
struct RosTransform {
  std::string parent, child;
  SE3 T;  // child -> parent
};
bool decode_transforms(Bytes bytes, bool cdr, std::vector<RosTransform>& out);

}  // namespace pirvs::tools
