#include "tools/run/run_mcap.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>

#include "core/math/so3.h"
#include "tools/dataset/left_images.h"
#include "tools/dataset/logs/mcap_writer.h"
#include "tools/dataset/logs/ros_writer.h"
#include "tools/dataset/player.h"
#include "tools/run/verdict.h"

namespace pirvs::tools {
namespace {

constexpr const char* kWorld = "odom";
constexpr const char* kBody = "base_link";
constexpr const char* kCamera = "cam0";
constexpr TimeNs kImagesEvery = 500'000'000, kHealthEvery = 1'000'000'000;

void put_matrix(RosMessage& message, const Mat6& m) {
  for (int i = 0; i < 36; ++i) message.number(m(i / 6, i % 6));
}

// The gyro's rate less its bias, of the sample at or behind t.
Vec3 rate_at(const Recording& recording, TimeNs t, const Vec3& bias) {
  const auto at =
      std::lower_bound(recording.imu.begin(), recording.imu.end(), t,
                       [](const ImuSample& sample, TimeNs time) { return sample.t < time; });
  return at == recording.imu.end() ? Vec3::Zero() : Vec3(at->w_B - bias);
}

RosMessage odometry(const Recording& recording, const FrameReport& frame) {
  const BodyState& state = frame.pose.state;
  const Mat3& R_WB = state.T_WB.R;
  const Vec3 v_B = R_WB.transpose() * state.v_WB;
  // Errors are those of attitude in B, position and velocity in W.
  Eigen::Matrix<double, 6, 9> to_pose = Eigen::Matrix<double, 6, 9>::Zero(), to_twist = to_pose;
  to_pose.block<3, 3>(0, 3) = Mat3::Identity();
  to_pose.block<3, 3>(3, 0) = R_WB;
  to_twist.block<3, 3>(0, 0) = skew(v_B);
  to_twist.block<3, 3>(0, 6) = R_WB.transpose();
  const Eigen::Matrix<double, 9, 9> cov = frame.pose.cov.topLeftCorner<9, 9>();
  const ImuNoise& noise = recording.calibration.imu;
  Mat6 cov_twist = to_twist * cov * to_twist.transpose();
  cov_twist.bottomRightCorner<3, 3>() =
      Mat3::Identity() * (noise.gyro_noise * noise.gyro_noise * noise.rate_hz);
  RosMessage out;
  out.header(frame.t, kWorld).text(kBody);
  out.vector(state.T_WB.p).quaternion(quat_xyzw(R_WB));
  put_matrix(out, to_pose * cov * to_pose.transpose());
  out.vector(v_B).vector(rate_at(recording, frame.t, state.b_g));
  put_matrix(out, cov_twist);
  return out;
}

RosMessage transform(TimeNs t, const char* frame, const char* child, const SE3& T) {
  RosMessage out;
  out.number(uint32_t{1});  // of one
  out.header(t, frame).text(child).vector(T.p).quaternion(quat_xyzw(T.R));
  return out;
}

RosMessage path(TimeNs t, const std::vector<TrajectoryPose>& poses) {
  RosMessage out;
  out.header(t, kWorld).number(uint32_t(poses.size()));
  for (const TrajectoryPose& pose : poses) {
    out.header(pose.t, kWorld).vector(pose.p_WB).quaternion(pose.q_WB);
  }
  return out;
}

std::vector<TrajectoryPose> keyframes(const RunLog& log) {
  std::vector<TrajectoryPose> out;
  for (const BodyState& state : log.keyframes) {
    TrajectoryPose pose;
    pose.t = state.t;
    pose.p_WB = state.T_WB.p;
    pose.q_WB = quat_xyzw(state.T_WB.R);
    out.push_back(pose);
  }
  return out;
}

// In the estimate's world.
std::vector<TrajectoryPose> truth(const Evaluation& evaluation) {
  std::vector<TrajectoryPose> out;
  const Mat3 R_EW = evaluation.R_WE.transpose();
  for (const EvalPose& matched : evaluation.matched) {
    TrajectoryPose pose;
    pose.t = matched.t;
    pose.p_WB = R_EW * (matched.p_truth_WB - evaluation.p_WE);
    pose.q_WB = quat_xyzw(R_EW * rotation_from_quat_xyzw(matched.q_truth_WB));
    out.push_back(pose);
  }
  return out;
}

RosMessage points(TimeNs t, const std::vector<Landmark>& landmarks) {
  constexpr uint8_t kFloat32 = 7;
  constexpr uint32_t kStep = 16;
  const char* const names[] = {"x", "y", "z", "sigma"};
  std::vector<float> data;
  for (const Landmark& point : landmarks) {
    for (int i = 0; i < 3; ++i) data.push_back(float(point.p_W[i]));
    data.push_back(float(std::sqrt(point.cov.trace())));
  }
  const auto count = uint32_t(landmarks.size());
  RosMessage out;
  out.header(t, kWorld).number(uint32_t{1}).number(count);
  out.number(uint32_t(std::size(names)));
  for (uint32_t i = 0; i < std::size(names); ++i) {
    out.text(names[i]).number(4 * i).number(kFloat32).number(uint32_t{1});
  }
  out.number(uint8_t{0}).number(kStep).number(kStep * count);
  out.block(reinterpret_cast<const uint8_t*>(data.data()), data.size() * sizeof(float));
  out.number(uint8_t{1});  // all of them finite
  return out;
}

RosMessage health(const FrameReport& frame) {
  constexpr uint8_t kOk = 0, kWarn = 1, kError = 2;
  const HealthState state = frame.has_pose ? frame.pose.health : HealthState::kInitializing;
  const Trust& trust = frame.pose.trust;
  const auto text = [](double value) {
    char out[32];
    std::snprintf(out, sizeof out, "%.4g", value);
    return std::string(out);
  };
  const Mat3 cov_p = frame.pose.cov.block<3, 3>(3, 3);
  const std::pair<const char*, std::string> values[] = {
      {"confidence", text(double(trust.confidence))},
      {"reasons", reasons_text(trust.reasons)},
      {"resets", std::to_string(trust.resets)},
      {"correspondences", std::to_string(frame.accepted)},
      {"position sigma [m]", text(std::sqrt(cov_p.trace()))},
      {"CPU [ms]", text(double(frame.end_to_end_ms))}};
  RosMessage out;
  out.header(frame.t, "").number(uint32_t{1});
  out.number(state == HealthState::kTracking ? kOk : state == HealthState::kLost ? kError : kWarn);
  out.text("pirvs").text(name(state)).text("");
  out.number(uint32_t(std::size(values)));
  for (const auto& [key, value] : values) out.text(key).text(value);
  return out;
}

// Frames of the left camera that are shown.
Recording shown(const Recording& recording) {
  Recording out = left_images(recording);
  TimeNs next = INT64_MIN;
  for (const FrameFiles& frame : recording.frames) {
    const bool has = !frame.image[0].empty() || frame.pixels[0].data != nullptr;
    if (frame.t < next || !has) continue;
    out.frames.push_back(frame);
    next = frame.t + kImagesEvery;
  }
  return out;
}

std::vector<uint8_t> jpeg(const ImageView& image) {
  constexpr int kQuality = 80;
  const cv::Mat pixels(image.height, image.width, CV_8UC1, const_cast<uint8_t*>(image.data),
                       size_t(image.stride));
  std::vector<uint8_t> out;
  cv::imencode(".jpg", pixels, out, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  return out;
}

class Images {
 public:
  Images(const Recording& recording, McapWriter& file)
      : shown_(shown(recording)),
        offset_(recording.calibration.camera_time_offset_ns),
        file_(file) {
    if (shown_.frames.empty()) return;
    channel_ = file.add_channel("/cam0/image_raw/compressed", kRosImage);
    player_.emplace(shown_);
    frame_ = player_->next();
  }
  void write_until(TimeNs t) {
    for (; frame_ != nullptr && frame_->t + offset_ <= t; frame_ = player_->next()) {
      if ((frame_->present & 1) != 0) {
        const auto file = jpeg(frame_->image[0]);
        const TimeNs t_imu = frame_->t + offset_;
        file_.write(channel_, t_imu, ros_image(t_imu, kCamera, "jpeg", file).bytes());
      }
      player_->release(frame_);
    }
  }

 private:
  Recording shown_;
  TimeNs offset_;
  McapWriter& file_;
  McapWriter::Channel channel_ = 0;
  std::optional<Player> player_;
  const StereoFrame* frame_ = nullptr;
};

// What stands from the first frame on.
void write_lasting(const Recording& recording, const RunLog& log, const RunResult& result,
                   McapWriter& file) {
  const TimeNs t = log.frames.front().t;
  const auto write = [&](const char* topic, const char* type, const RosMessage& message) {
    file.write(file.add_channel(topic, type), t, message.bytes());
  };
  write("/tf_static", "tf2_msgs/msg/TFMessage",
        transform(t, kBody, kCamera, recording.calibration.camera[0].T_BC));
  write("/map_points", "sensor_msgs/msg/PointCloud2", points(t, log.points));
  write("/keyframes", "nav_msgs/msg/Path", path(t, keyframes(log)));
  if (result.evaluation.ok) write("/truth", "nav_msgs/msg/Path", path(t, truth(result.evaluation)));
}

}  // namespace

std::string run_mcap(const Recording& recording, const RunLog& log, const RunResult& result) {
  std::ostringstream out;
  McapWriter file(out);
  if (!log.frames.empty()) write_lasting(recording, log, result, file);
  const auto odom = file.add_channel("/odom", "nav_msgs/msg/Odometry");
  const auto tf = file.add_channel("/tf", "tf2_msgs/msg/TFMessage");
  const auto state = file.add_channel("/health", "diagnostic_msgs/msg/DiagnosticArray");
  Images images(recording, file);
  TimeNs next_health = INT64_MIN;
  HealthState said = HealthState::kCount;
  for (const FrameReport& frame : log.frames) {
    images.write_until(frame.t);
    if (frame.t >= next_health || frame.pose.health != said) {
      file.write(state, frame.t, health(frame).bytes());
      next_health = frame.t + kHealthEvery;
      said = frame.pose.health;
    }
    if (!frame.has_pose) continue;
    file.write(odom, frame.t, odometry(recording, frame).bytes());
    file.write(tf, frame.t, transform(frame.t, kWorld, kBody, frame.pose.state.T_WB).bytes());
  }
  file.finish();
  return out.str();
}

}  // namespace pirvs::tools
