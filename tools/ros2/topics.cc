#include "tools/ros2/topics.h"

#include <Messages.h>  // made of Messages.idl
#include <dds/dds.h>

#include <cstring>
#include <iterator>
#include <vector>

#include "core/math/so3.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// By Topics::Kind. Hashes: REP 2011.
struct Type {
  const dds_topic_descriptor_t* descriptor;
  const char* hash;
  int kept;
  bool for_late_ones;
};
const Type kTypes[] = {
    {&nav_msgs_msg_dds__Odometry__desc,
     "typehash=RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0;", 10,
     false},
    {&tf2_msgs_msg_dds__TFMessage__desc,
     "typehash=RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087;", 100,
     false},
    {&sensor_msgs_msg_dds__Imu__desc,
     "typehash=RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b;", 10,
     false},
    {&sensor_msgs_msg_dds__PointCloud2__desc,
     "typehash=RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5;", 1, true},
};

// One network, and no multicast on loopback, which has none: whoever is there is asked by address.
std::string domain_xml(const std::string& network) {
  const bool loopback = network.rfind("127.", 0) == 0;
  return "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"" + network +
         "\"/></Interfaces><AllowMulticast>" + (loopback ? "false" : "default") +
         "</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>" +
         (loopback ? "<Peers><Peer Address=\"localhost\"/></Peers>" : "") +
         "</Discovery></Domain></CycloneDDS>";
}

int32_t check(dds_entity_t entity, const char* what, const std::string& network) {
  if (entity >= 0) return entity;
  throw InputError(std::string(what) + ": " + dds_strretcode(entity), network,
                   "name an address of this machine by --network");
}

void put_stamp(TimeNs t, const std::string& frame, std_msgs_msg_dds__Header_& out) {
  constexpr TimeNs kSecond_ns = 1'000'000'000;
  out.stamp_.sec_ = static_cast<int32_t>(t / kSecond_ns);
  out.stamp_.nanosec_ = static_cast<uint32_t>(t % kSecond_ns);
  out.frame_id_ = const_cast<char*>(frame.c_str());
}

geometry_msgs_msg_dds__Vector3_ vector_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

void put(const Mat3& from, int at, double (&to)[36]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) to[(at + i) * 6 + at + j] = from(i, j);
  }
}

void put_diagonal(double variance, double (&to)[9]) {
  for (int i = 0; i < 3; ++i) to[4 * i] = variance;
}

}  // namespace

Topics::Topics(const TopicOptions& options) : frame_(options.frame), child_(options.child) {
  const std::string& network = options.network;
  domain_ = check(dds_create_domain(options.domain, domain_xml(network).c_str()), "DDS", network);
  participant_ = check(dds_create_participant(options.domain, nullptr, nullptr), "DDS", network);
  open(kOdom, options.odom, network);
  open(kTf, options.tf, network);
  open(kImu, options.imu, network);
  open(kPoints, options.points, network);
}

void Topics::open(Kind kind, const std::string& topic, const std::string& network) {
  if (topic.empty()) return;
  const Type& type = kTypes[kind];
  const std::string name = "rt/" + topic;
  const dds_entity_t of =
      check(dds_create_topic(participant_, type.descriptor, name.c_str(), nullptr, nullptr),
            "topic", network);
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(10));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, type.kept);
  if (type.for_late_ones) dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_userdata(qos, type.hash, std::strlen(type.hash));
  const dds_entity_t writer = dds_create_writer(participant_, of, qos, nullptr);
  dds_delete_qos(qos);
  writers_[kind] = check(writer, "writer", network);
}

Topics::~Topics() {
  if (participant_ > 0) dds_delete(participant_);
  if (domain_ > 0) dds_delete(domain_);
}

int Topics::readers() const {
  int count = 0;
  for (const int32_t writer : writers_) {
    dds_publication_matched_status_t status{};
    if (writer == 0) continue;
    if (dds_get_publication_matched_status(writer, &status) != DDS_RETCODE_OK) continue;
    count += static_cast<int>(status.current_count);
  }
  return count;
}

void Topics::pose(const stream::PoseMessage& pose, TimeNs offset_ns) {
  if (pose.epoch != epoch_) points_.clear();  // of another world
  epoch_ = pose.epoch;
  nav_msgs_msg_dds__Odometry_ out{};
  put_stamp(pose.t + offset_ns, frame_, out.header_);
  out.child_frame_id_ = child_.data();
  auto& place = out.pose_.pose_;
  place.position_ = {pose.p_WB.x(), pose.p_WB.y(), pose.p_WB.z()};
  const Vec4 q = pose.q_xyzw.normalized();
  place.orientation_ = {q(0), q(1), q(2), q(3)};
  const Mat3 R_WB = rotation_from_quat_xyzw(q);
  const Vec3 v_B = R_WB.transpose() * pose.v_WB;
  out.twist_.twist_ = {vector_of(v_B), vector_of(pose.w_B)};
  const Mat3 cov_theta = pose.cov_theta_p.topLeftCorner<3, 3>();
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J.block<3, 3>(0, 3) = Mat3::Identity();
  J.block<3, 3>(3, 0) = R_WB;
  const Mat6 cov_pose = J * pose.cov_theta_p * J.transpose();
  for (int i = 0; i < 36; ++i) out.pose_.covariance_[i] = cov_pose(i / 6, i % 6);
  // The stream does not tell how attitude and velocity are correlated.
  const Mat3 turn = skew(v_B);
  put(R_WB.transpose() * pose.cov_v * R_WB + turn * cov_theta * turn.transpose(), 0,
      out.twist_.covariance_);
  put(Mat3::Identity() * (noise_.gyro_noise * noise_.gyro_noise * noise_.rate_hz), 3,
      out.twist_.covariance_);
  if (writers_[kOdom] != 0) (void)dds_write(writers_[kOdom], &out);
  if (writers_[kTf] == 0) return;
  geometry_msgs_msg_dds__TransformStamped_ transform{};
  transform.header_ = out.header_;
  transform.child_frame_id_ = out.child_frame_id_;
  transform.transform_ = {vector_of(pose.p_WB), place.orientation_};
  tf2_msgs_msg_dds__TFMessage_ message{};
  message.transforms_._buffer = &transform;
  message.transforms_._length = message.transforms_._maximum = 1;
  (void)dds_write(writers_[kTf], &message);
}

void Topics::imu(const ImuSample& sample, TimeNs offset_ns) {
  if (writers_[kImu] == 0) return;
  sensor_msgs_msg_dds__Imu_ out{};
  put_stamp(sample.t + offset_ns, child_, out.header_);
  out.orientation_.w_ = 1;
  out.orientation_covariance_[0] = -1;  // there is none
  out.angular_velocity_ = vector_of(sample.w_B);
  out.linear_acceleration_ = vector_of(sample.f_B);
  put_diagonal(noise_.gyro_noise * noise_.gyro_noise * noise_.rate_hz,
               out.angular_velocity_covariance_);
  put_diagonal(noise_.accel_noise * noise_.accel_noise * noise_.rate_hz,
               out.linear_acceleration_covariance_);
  (void)dds_write(writers_[kImu], &out);
}

void Topics::points(const stream::PointsMessage& points, bool last, TimeNs offset_ns) {
  if (writers_[kPoints] == 0) return;
  for (int i = 0; i < points.count; ++i) points_[points.points[i].id] = points.points[i];
  while (points_.size() > kPointsMax) points_.erase(points_.begin());
  if (!last) return;
  constexpr uint8_t kFloat32 = 7;
  constexpr uint32_t kStep = 16;
  static constexpr const char* kNames[] = {"x", "y", "z", "sigma"};
  sensor_msgs_msg_dds__PointField_ fields[4] = {};
  for (uint32_t i = 0; i < std::size(fields); ++i) {
    fields[i] = {const_cast<char*>(kNames[i]), 4 * i, kFloat32, 1};
  }
  std::vector<float> data;
  data.reserve(4 * points_.size());
  for (const auto& [id, point] : points_) {
    for (int i = 0; i < 3; ++i) data.push_back(point.p_W(i));
    data.push_back(point.sigma_m);
  }
  sensor_msgs_msg_dds__PointCloud2_ out{};
  put_stamp(points.t + offset_ns, frame_, out.header_);
  out.height_ = 1;
  out.width_ = static_cast<uint32_t>(points_.size());
  out.fields_._buffer = fields;
  out.fields_._length = out.fields_._maximum = static_cast<uint32_t>(std::size(fields));
  out.point_step_ = kStep;
  out.row_step_ = kStep * out.width_;
  out.data_._buffer = reinterpret_cast<uint8_t*>(data.data());
  out.data_._length = out.data_._maximum = out.row_step_;
  out.is_dense_ = true;
  (void)dds_write(writers_[kPoints], &out);
}

}  // namespace pirvs::tools
