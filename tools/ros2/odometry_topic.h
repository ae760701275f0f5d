// What    Poses as nav_msgs/Odometry on a topic of ROS 2, without ROS: DDS by Cyclone DDS, and the
//         type by Odometry.idl.
// In      Poses of a device's stream; the topic's name without its slash; frame names; the DDS
//         domain (ROS_DOMAIN_ID); the address of the network to speak on.
// Out     A reliable writer, which both kinds of readers match, that keeps the last ten. Type name
//         and type hash (user data of the writer, since ROS 2 Iron) are those of ROS.
// Frames  REP 105: `frame` is W, `child` is B. Pose and its covariance in W, the attitude's about
//         W's fixed axes; twist and its covariance in B.
// Units   m, rad, m/s, rad/s. Stamps: as the device's, or moved by `offset_ns`.
// Errors  InputError: no such network. A reader that is slow loses its own.
// Source  ROS 2 design, "Topic and service name mapping to DDS"; REP 103, 105, 2011 (type hashes).
#pragma once

#include <cstdint>
#include <string>

#include "modules/stream/stream.h"

namespace pirvs::tools {

struct OdometryOptions {
  std::string topic = "odom", frame = "odom", child = "base_link";
  uint32_t domain = 0;
  std::string network = "127.0.0.1";  // one of this machine's addresses
};

class OdometryTopic {
 public:
  explicit OdometryTopic(const OdometryOptions& options);
  ~OdometryTopic();
  OdometryTopic(const OdometryTopic&) = delete;
  OdometryTopic& operator=(const OdometryTopic&) = delete;

  void write(const stream::PoseMessage& pose, TimeNs offset_ns);
  int readers() const;

 private:
  std::string frame_, child_;
  int32_t domain_ = 0, participant_ = 0, writer_ = 0;
};

}  // namespace pirvs::tools
