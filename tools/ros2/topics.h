// What    What a device tells, on topics of ROS 2 without ROS: DDS by Cyclone DDS, and the types by
//         Messages.idl.
//           /odom        nav_msgs/Odometry, each pose
//           /tf          tf2_msgs/TFMessage, the same pose as a transform from `frame` to `child`
//           /imu         sensor_msgs/Imu, each sample as measured; without an orientation
//           /map_points  sensor_msgs/PointCloud2, float32 x, y, z and sigma of all landmarks of the
//                        epoch that were seen, in `frame`; twice a second
// In      Messages of a device's stream; frame names; the DDS domain (ROS_DOMAIN_ID); the address
//         of the network to speak on.
// Out     Reliable writers, which both kinds of readers match; they keep the last ten, /tf the last
//         hundred as ROS does, /map_points the last for whoever comes late (transient local). Type
//         names and type hashes (user data of the writers, since ROS 2 Iron) are those of ROS.
// Frames  REP 103, 105: `frame` is W, `child` is B, which is the IMU. Pose and its covariance in W,
//         the attitude's about W's fixed axes; twist and its covariance in B.
// Units   m, rad, m/s, rad/s, m/s^2. Stamps: as the device's, or moved by `offset_ns`.
// Errors  InputError: no such network. A reader that is slow loses its own.
// Cost    ~10 us a message and reader; 16 bytes a landmark, kPointsMax at most.
// Source  ROS 2 design, "Topic and service name mapping to DDS"; REP 103, 105, 145 (IMU drivers),
//         2011 (type hashes).
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "modules/imu/imu_noise.h"
#include "modules/stream/stream.h"

namespace pirvs::tools {

struct TopicOptions {
  std::string odom = "odom", tf = "tf", imu = "imu", points = "map_points";  // empty: none
  std::string frame = "odom", child = "base_link";
  uint32_t domain = 0;
  std::string network = "127.0.0.1";  // one of this machine's addresses
};

class Topics {
 public:
  static constexpr size_t kPointsMax = 200'000;

  explicit Topics(const TopicOptions& options);
  ~Topics();
  Topics(const Topics&) = delete;
  Topics& operator=(const Topics&) = delete;

  void pose(const stream::PoseMessage& pose, TimeNs offset_ns);
  void imu(const ImuSample& sample, TimeNs offset_ns);
  // One part after the other; written at the last.
  void points(const stream::PointsMessage& points, bool last, TimeNs offset_ns);
  int readers() const;  // of all topics

 private:
  enum Kind : int { kOdom, kTf, kImu, kPoints, kKinds };

  void open(Kind kind, const std::string& topic, const std::string& network);

  std::string frame_, child_;
  ImuNoise noise_;
  int32_t domain_ = 0, participant_ = 0;
  int32_t writers_[kKinds] = {0, 0, 0, 0};  // 0: none
  uint16_t epoch_ = 0;
  std::map<uint32_t, stream::Point> points_;
};

}  // namespace pirvs::tools
