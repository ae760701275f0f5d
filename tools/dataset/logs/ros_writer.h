// What    Messages of ROS 2 as bytes, and what their types are, for logs (mcap_writer.h).
// In      Values in the units of REP 103.
// Out     CDR, little endian, each number at a multiple of its size; definitions as ros2msg has
//         them, with those of the types that they use behind.
// Frames  frame: that of the pose or the sensor; child: of the body.
// Units   m, rad/s, m/s^2; t in ns, of which whole seconds must fit 32 bits.
// Errors  ros_definition of a type that is not known here asserts.
// Cost    ~0.2 us a message besides its pixels.
// Source  ros2/common_interfaces, tf2_msgs, diagnostic_msgs; OMG DDS-XTypes 1.3, 7.4 (plain CDR).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bsp/api/imu.h"
#include "core/math/types.h"

namespace pirvs::tools {

// Of "nav_msgs/msg/Odometry" and alike.
std::string ros_definition(const std::string& type);

// A message, field by field.
class RosMessage {
 public:
  RosMessage();
  template <class T>
  RosMessage& number(T value) {
    align(sizeof(T));
    const auto* const raw = reinterpret_cast<const uint8_t*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof(T));
    return *this;
  }
  RosMessage& text(const std::string& value);
  RosMessage& block(const uint8_t* data, size_t size);  // with its size in front
  RosMessage& vector(const Vec3& v);
  RosMessage& quaternion(const Vec4& xyzw);
  RosMessage& zeros(int numbers);
  RosMessage& time(TimeNs t);
  RosMessage& header(TimeNs t, const std::string& frame);
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<uint8_t> bytes_;
  void align(size_t to);
};

// Whole ones.
inline constexpr const char* kRosImu = "sensor_msgs/msg/Imu";
inline constexpr const char* kRosImage = "sensor_msgs/msg/CompressedImage";
inline constexpr const char* kRosPose = "geometry_msgs/msg/PoseStamped";
RosMessage ros_imu(const ImuSample& sample, const std::string& frame);
// format: "jpeg", "png".
RosMessage ros_image(TimeNs t, const std::string& frame, const std::string& format,
                     const std::vector<uint8_t>& file);
RosMessage ros_pose(TimeNs t, const std::string& frame, const Vec3& p, const Vec4& q_xyzw);

}  // namespace pirvs::tools
