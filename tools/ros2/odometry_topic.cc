#include "tools/ros2/odometry_topic.h"

#include <Odometry.h>  // made of Odometry.idl
#include <dds/dds.h>

#include "core/math/so3.h"
#include "modules/imu/imu_noise.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// REP 2011, of nav_msgs/msg/Odometry.
constexpr const char* kTypeHash =
    "typehash=RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0;";
constexpr int kKept = 10;

// One network, and no multicast on loopback, which has none: whoever is there is asked by address.
std::string domain_xml(const std::string& network) {
  const bool loopback = network.rfind("127.", 0) == 0;
  return "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"" + network +
         "\"/></Interfaces><AllowMulticast>" + (loopback ? "false" : "default") +
         "</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>" +
         (loopback ? "<Peers><Peer Address=\"localhost\"/></Peers>" : "") +
         "</Discovery></Domain></CycloneDDS>";
}

void put(const Mat3& from, int at, double (&to)[36]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) to[(at + i) * 6 + at + j] = from(i, j);
  }
}

}  // namespace

OdometryTopic::OdometryTopic(const OdometryOptions& options)
    : frame_(options.frame), child_(options.child) {
  const auto check = [&](dds_entity_t entity, const char* what) {
    if (entity >= 0) return entity;
    throw InputError(std::string(what) + ": " + dds_strretcode(entity), options.network,
                     "name an address of this machine by --network");
  };
  domain_ = check(dds_create_domain(options.domain, domain_xml(options.network).c_str()), "DDS");
  participant_ = check(dds_create_participant(options.domain, nullptr, nullptr), "DDS");
  const std::string name = "rt/" + options.topic;
  const dds_entity_t topic = check(dds_create_topic(participant_, &nav_msgs_msg_dds__Odometry__desc,
                                                    name.c_str(), nullptr, nullptr),
                                   "topic");
  dds_qos_t* const qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(10));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, kKept);
  dds_qset_userdata(qos, kTypeHash, std::char_traits<char>::length(kTypeHash));
  const dds_entity_t writer = dds_create_writer(participant_, topic, qos, nullptr);
  dds_delete_qos(qos);
  writer_ = check(writer, "writer");
}

OdometryTopic::~OdometryTopic() {
  if (participant_ > 0) dds_delete(participant_);
  if (domain_ > 0) dds_delete(domain_);
}

int OdometryTopic::readers() const {
  dds_publication_matched_status_t status{};
  return dds_get_publication_matched_status(writer_, &status) == DDS_RETCODE_OK
             ? static_cast<int>(status.current_count)
             : 0;
}

void OdometryTopic::write(const stream::PoseMessage& pose, TimeNs offset_ns) {
  constexpr TimeNs kSecond_ns = 1'000'000'000;
  const TimeNs t = pose.t + offset_ns;
  nav_msgs_msg_dds__Odometry_ out{};
  out.header_.stamp_.sec_ = static_cast<int32_t>(t / kSecond_ns);
  out.header_.stamp_.nanosec_ = static_cast<uint32_t>(t % kSecond_ns);
  out.header_.frame_id_ = frame_.data();
  out.child_frame_id_ = child_.data();
  auto& place = out.pose_.pose_;
  place.position_ = {pose.p_WB.x(), pose.p_WB.y(), pose.p_WB.z()};
  const Vec4 q = pose.q_xyzw.normalized();
  place.orientation_ = {q(0), q(1), q(2), q(3)};
  const Mat3 R_WB = rotation_from_quat_xyzw(q);
  const Vec3 v_B = R_WB.transpose() * pose.v_WB;
  out.twist_.twist_.linear_ = {v_B.x(), v_B.y(), v_B.z()};
  out.twist_.twist_.angular_ = {pose.w_B.x(), pose.w_B.y(), pose.w_B.z()};
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
  const ImuNoise noise;
  put(Mat3::Identity() * (noise.gyro_noise * noise.gyro_noise * noise.rate_hz), 3,
      out.twist_.covariance_);
  (void)dds_write(writer_, &out);
}

}  // namespace pirvs::tools
