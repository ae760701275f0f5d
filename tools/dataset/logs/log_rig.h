// What    The rig of a log that says it itself: lenses by sensor_msgs/CameraInfo, poses by tf.
// In      Of each camera its CameraInfo and the names of its topic and frame; the IMU's frame; all
//         transforms of /tf_static and /tf.
// Out     A RigFile, cameras in their order.
// Frames  A CameraInfo's R takes the camera's coordinates to those of its rectified image, P has
//         where the camera stands in the first one's: P[3] = -fx * x, P[7] = -fy * y. A transform
//         takes child to parent coordinates. B = the IMU's frame.
// Units   pixels, (0,0) at the centre of the first one; metres.
// Errors  InputError: not calibrated, a lens model that is not known, no transform from the camera
//         to the IMU, no baseline.
// Source  sensor_msgs/CameraInfo, tf2_msgs/TFMessage; ROS REP 104; image_geometry (binning, region
//         of interest).
#pragma once

#include <string>
#include <vector>

#include "tools/dataset/calibration/rig_file.h"
#include "tools/dataset/logs/ros_message.h"

namespace pirvs::tools {

struct LogCamera {
  std::string topic, frame_id;  // of the images
  std::string info_topic;
  CameraInfo info;
};

RigFile rig_of_log(const std::string& path, const std::vector<LogCamera>& cameras,
                   const std::string& imu_frame, const std::vector<RosTransform>& transforms);
// The topic of a camera's CameraInfo, beside its images.
std::string info_topic_of(const std::string& image_topic);

}  // namespace pirvs::tools
