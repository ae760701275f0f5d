#include "tools/dataset/logs/ros_writer.h"

#include <iterator>
#include <sstream>

#include "core/base/assert.h"

namespace pirvs::tools {
namespace {

constexpr TimeNs kSecond = 1'000'000'000;
constexpr size_t kEncapsulation = 4;  // what CDR's alignment does not count

struct Definition {
  const char *type, *text;
};
constexpr Definition kDefinitions[] = {
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/PoseStamped", "std_msgs/Header header\ngeometry_msgs/Pose pose\n"},
    {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    {"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
    {"geometry_msgs/Transform",
     "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    {"geometry_msgs/TransformStamped",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    {"nav_msgs/Odometry",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist\n"},
    {"nav_msgs/Path", "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n"},
    {"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    {"sensor_msgs/Imu",
     "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
     "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
     "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
     "float64[9] linear_acceleration_covariance\n"},
    {"sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"},
    {"sensor_msgs/PointField", "string name\nuint32 offset\nuint8 datatype\nuint32 count\n"},
    {"sensor_msgs/PointCloud2",
     "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\n"
     "bool is_bigendian\nuint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n"},
    {"diagnostic_msgs/KeyValue", "string key\nstring value\n"},
    {"diagnostic_msgs/DiagnosticStatus",
     "byte level\nstring name\nstring message\nstring hardware_id\n"
     "diagnostic_msgs/KeyValue[] values\n"},
    {"diagnostic_msgs/DiagnosticArray",
     "std_msgs/Header header\ndiagnostic_msgs/DiagnosticStatus[] status\n"},
};

const char* text_of(const std::string& type) {
  for (const Definition& known : kDefinitions) {
    if (type == known.type) return known.text;
  }
  PIRVS_ASSERT(!"a type of ROS that is not in the table");
  return "";
}

// The types that a definition uses, each once, behind those that are known.
void collect(const std::string& type, std::vector<std::string>& known) {
  std::istringstream lines(text_of(type));
  for (std::string word, field; lines >> word >> field;) {
    word = word.substr(0, word.find('['));
    if (word.find('/') == std::string::npos) continue;
    bool is_known = false;
    for (const std::string& one : known) is_known = is_known || one == word;
    if (is_known) continue;
    known.push_back(word);
    collect(word, known);
  }
}

}  // namespace

std::string ros_definition(const std::string& type) {
  std::string plain = type;
  const size_t middle = plain.find("/msg/");
  if (middle != std::string::npos) plain.replace(middle, 5, "/");
  std::vector<std::string> used;
  collect(plain, used);
  std::string out = text_of(plain);
  for (const std::string& one : used) {
    out += std::string(80, '=') + "\nMSG: " + one + "\n" + text_of(one);
  }
  return out;
}

RosMessage::RosMessage() : bytes_{0, 1, 0, 0} {}

void RosMessage::align(size_t to) {
  while ((bytes_.size() - kEncapsulation) % to != 0) bytes_.push_back(0);
}

RosMessage& RosMessage::text(const std::string& value) {
  number(uint32_t(value.size() + 1));
  bytes_.insert(bytes_.end(), value.begin(), value.end());
  bytes_.push_back(0);
  return *this;
}

RosMessage& RosMessage::block(const uint8_t* data, size_t size) {
  number(uint32_t(size));
  bytes_.insert(bytes_.end(), data, data + size);
  return *this;
}

RosMessage& RosMessage::vector(const Vec3& v) { return number(v.x()).number(v.y()).number(v.z()); }

RosMessage& RosMessage::quaternion(const Vec4& xyzw) {
  return number(xyzw[0]).number(xyzw[1]).number(xyzw[2]).number(xyzw[3]);
}

RosMessage& RosMessage::zeros(int numbers) {
  for (int i = 0; i < numbers; ++i) number(0.0);
  return *this;
}

RosMessage& RosMessage::time(TimeNs t) {
  // Nanoseconds are positive, also before 1970.
  const TimeNs below = (t % kSecond + kSecond) % kSecond;
  return number(int32_t((t - below) / kSecond)).number(uint32_t(below));
}

RosMessage& RosMessage::header(TimeNs t, const std::string& frame) { return time(t).text(frame); }

RosMessage ros_imu(const ImuSample& sample, const std::string& frame) {
  RosMessage out;
  out.header(sample.t, frame).quaternion(Vec4(0, 0, 0, 1));
  out.number(-1.0).zeros(8);  // there is no orientation
  out.vector(sample.w_B).zeros(9).vector(sample.f_B).zeros(9);
  return out;
}

RosMessage ros_image(TimeNs t, const std::string& frame, const std::string& format,
                     const std::vector<uint8_t>& file) {
  RosMessage out;
  out.header(t, frame).text(format).block(file.data(), file.size());
  return out;
}

RosMessage ros_pose(TimeNs t, const std::string& frame, const Vec3& p, const Vec4& q_xyzw) {
  RosMessage out;
  out.header(t, frame).vector(p).quaternion(q_xyzw);
  return out;
}

}  // namespace pirvs::tools
