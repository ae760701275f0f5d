// What    A run as an MCAP file that Foxglove, Lichtblick and rosbag2 open: run.mcap.
// In      Recording, RunLog, RunResult.
// Out     Messages of ROS 2, names as those of `pirvs ros2`:
//           /odom        nav_msgs/Odometry, each frame's pose
//           /tf          tf2_msgs/TFMessage, odom to base_link, the same; /tf_static, the left
//                        camera
//           /map_points  sensor_msgs/PointCloud2, x y z sigma of the map at the end, at the first
//                        frame's time, so that it is there throughout
//           /keyframes   nav_msgs/Path, likewise; /truth, with a truth, aligned to the estimate
//           /health      diagnostic_msgs/DiagnosticArray, when it changes and once a second
//           /cam0/image_raw/compressed  JPEG of the left camera, twice a second
// Frames  REP 103, 105: odom is W, base_link is B. As tools/ros2/topics.h.
// Units   m, rad, m/s, rad/s; stamps on the IMU's clock.
// Errors  none; images that cannot be read are left out.
// Cost    ~2 kB a frame, and two images a second, in memory until it is written.
// Source  mcap.dev; ros2/common_interfaces.
#pragma once

#include <string>

#include "tools/run/result.h"

namespace pirvs::tools {

std::string run_mcap(const Recording& recording, const RunLog& log, const RunResult& result);

}  // namespace pirvs::tools
