// `pirvs ros2` against a program that shares the types' public definitions with it, and no more.
// In      PIRVS_BUILD (default build): host/pirvs, ros2/reader.
// Cost    ~8 s.
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "bsp/api/clock.h"
#include "bsp/api/datagram.h"
#include "core/math/so3.h"
#include "modules/imu/imu_noise.h"
#include "modules/stream/stream.h"
#include "modules/testing.h"
#include "tests/programs.h"
#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

constexpr int kPoses = 200;

Pose pose_of(int k, testing::Random& random) {
  Pose pose;
  pose.state = random.state();
  pose.state.t = 5'000'000'123 + k * TimeNs{5'000'000};
  pose.w_B = random.vec(1);
  Mat9 root;
  for (int i = 0; i < 81; ++i) root(i / 9, i % 9) = random.gauss(0.05);
  pose.cov = root * root.transpose();
  pose.health = HealthState::kTracking;
  pose.trust.confidence = 1;
  return pose;
}

struct Heard {
  std::string writer, frame, child;
  TimeNs t = 0;
  double pose[7], pose_cov[36], twist[6], twist_cov[36];
};

// Lines behind the one that names the writer.
std::vector<std::string> lines_of(const std::string& file, std::string& writer) {
  std::vector<std::string> out;
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("writer ", 0) == 0) {
      writer = line.substr(7);
    } else {
      out.push_back(line);
    }
  }
  return out;
}

TimeNs read_stamp(std::istringstream& text, std::string& frame) {
  int64_t sec = 0, nanosec = 0;
  text >> sec >> nanosec >> frame;
  return sec * 1'000'000'000 + nanosec;
}

Heard odom_of(const std::string& line) {
  std::istringstream text(line);
  Heard one;
  one.t = read_stamp(text, one.frame);
  text >> one.child;
  for (double& x : one.pose) text >> x;
  for (double& x : one.pose_cov) text >> x;
  for (double& x : one.twist) text >> x;
  for (double& x : one.twist_cov) text >> x;
  EXPECT_FALSE(text.fail()) << line;
  return one;
}

// What is said against what is heard, to 1e-9: floats are rounded by both alike.
class Differences {
 public:
  void add(double said, double heard) { largest_ = std::max(largest_, std::fabs(said - heard)); }
  ~Differences() { EXPECT_LT(largest_, 1e-9); }
  double largest() const { return largest_; }

 private:
  double largest_ = 0;
};

// The pose as the stream carries it.
stream::PoseMessage carried(const Pose& pose) {
  uint8_t bytes[stream::kMax];
  stream::Header header;
  stream::PoseMessage out;
  EXPECT_TRUE(stream::decode(bytes, stream::encode(pose, 0, bytes), header));
  EXPECT_TRUE(stream::decode(header, bytes + stream::kHeaderBytes, out));
  return out;
}

void expect_odom(const Pose& pose, const Heard& heard, Differences& d) {
  EXPECT_EQ(heard.t, pose.state.t);
  EXPECT_EQ(heard.frame, "odom");
  EXPECT_EQ(heard.child, "base_link");
  const stream::PoseMessage said = carried(pose);
  const Vec4 q = said.q_xyzw.normalized();
  const Mat3 R = rotation_from_quat_xyzw(q);
  EXPECT_LT((R - pose.state.T_WB.R).norm(), 1e-6) << "floats on the way";
  const Vec3 v_B = R.transpose() * said.v_WB;
  for (int i = 0; i < 4; ++i) d.add(q(i), heard.pose[3 + i]);
  const auto cov = [&](const double(&from)[36], int i, int j) { return from[i * 6 + j]; };
  const Mat3 attitude = R * said.cov_theta_p.topLeftCorner<3, 3>() * R.transpose();
  const Mat3 cross = said.cov_theta_p.bottomLeftCorner<3, 3>() * R.transpose();
  for (int i = 0; i < 3; ++i) {
    d.add(pose.state.T_WB.p(i), heard.pose[i]);
    d.add(v_B(i), heard.twist[i]);
    d.add(said.w_B(i), heard.twist[3 + i]);
    for (int j = 0; j < 3; ++j) {
      d.add(said.cov_theta_p(3 + i, 3 + j), cov(heard.pose_cov, i, j));
      d.add(attitude(i, j), cov(heard.pose_cov, 3 + i, 3 + j));
      d.add(cross(i, j), cov(heard.pose_cov, i, 3 + j));
      EXPECT_EQ(cov(heard.twist_cov, i, 3 + j), 0);
    }
  }
}

void expect_tf(const Pose& pose, const std::string& line, Differences& d) {
  std::istringstream text(line);
  std::string frame, child;
  EXPECT_EQ(read_stamp(text, frame), pose.state.t);
  text >> child;
  EXPECT_EQ(frame, "odom");
  EXPECT_EQ(child, "base_link");
  const Vec4 q = carried(pose).q_xyzw.normalized();
  double x = 0;
  for (int i = 0; i < 7 && text >> x; ++i) d.add(i < 3 ? pose.state.T_WB.p(i) : q(i - 3), x);
  EXPECT_FALSE(text.fail()) << line;
}

void expect_imu(const ImuSample& said, const std::string& line, Differences& d) {
  std::istringstream text(line);
  std::string frame;
  EXPECT_EQ(read_stamp(text, frame), said.t);
  EXPECT_EQ(frame, "base_link");
  const ImuNoise noise;
  const double variance[] = {noise.gyro_noise * noise.gyro_noise * noise.rate_hz,
                             noise.accel_noise * noise.accel_noise * noise.rate_hz};
  double x = 0;
  text >> x;
  EXPECT_EQ(x, -1) << "no orientation";
  for (int k = 0; k < 2; ++k) {
    for (int i = 0; i < 3 && text >> x; ++i) d.add(k == 0 ? said.w_B(i) : said.f_B(i), x);
    for (int i = 0; i < 9 && text >> x; ++i) d.add(i % 4 == 0 ? variance[k] : 0, x);
  }
  EXPECT_FALSE(text.fail()) << line;
}

// A device's end of the stream.
class Device {
 public:
  Device() {
    const Result<bsp::Socket> socket = bsp::datagram_open({0x7f00'0001, 0});
    EXPECT_TRUE(socket.ok());
    socket_ = socket.value();
  }
  ~Device() { bsp::datagram_close(socket_); }
  uint16_t port() const { return bsp::datagram_port(socket_).value(); }

  // Answers whoever asks for the time, and sends to him.
  void poll() {
    uint8_t bytes[stream::kMax];
    size_t size = 0;
    while (bsp::datagram_receive(socket_, bytes, sizeof bytes, size, to_) == Status::kOk) {
      stream::Header header;
      stream::ClockMessage asked;
      if (!stream::decode(bytes, size, header) ||
          !stream::decode(header, bytes + stream::kHeaderBytes, asked)) {
        continue;
      }
      asked.t_device = bsp::now();
      send([&](uint8_t* out) { return stream::encode(asked, stream::Kind::kClock, 0, out); });
    }
  }
  template <class Message>
  void say(const Message& message) {
    send([&](uint8_t* out) { return stream::encode(message, sequence_++, out); });
  }
  void say(const stream::PointsMessage& points, uint16_t part, uint16_t parts) {
    stream::Header header;
    header.kind = stream::Kind::kPoints;
    header.part = part;
    header.parts = parts;
    header.sequence = sequence_++;
    send([&](uint8_t* out) { return stream::encode(points, header, out); });
  }

 private:
  template <class Encode>
  void send(Encode encode) {
    uint8_t bytes[stream::kMax];
    const size_t size = encode(bytes);
    EXPECT_EQ(bsp::datagram_send(socket_, to_, bytes, size), Status::kOk);
  }

  bsp::Socket socket_;
  bsp::Endpoint to_;
  uint32_t sequence_ = 0;
};

// Of each kind what the device says, and what a reader of each topic has heard of it.
class Ros2 : public ::testing::Test {
 protected:
  static constexpr const char* kTopics[] = {"odom", "tf", "imu", "map_points"};

  void talk() {
    Device device;
    const std::string domain = std::to_string(100 + getpid() % 100), build = build_folder();
    std::string command = build + "/host/pirvs ros2 127.0.0.1:" + std::to_string(device.port()) +
                          " --device-time --domain " + domain + " --duration 9 2> " + out_ +
                          "log & sleep 1; ";
    for (const char* const topic : kTopics) {
      command += build + "/ros2/reader " + domain + " 8 " + topic + " > " + out_ + topic + " & ";
    }
    std::thread others([&] { EXPECT_EQ(std::system((command + "wait").c_str()), 0); });
    for (const TimeNs begin = bsp::now(); bsp::now() - begin < 4'000'000'000;) {
      device.poll();  // until all have found each other
      usleep(5'000);
    }
    testing::Random random(1);
    for (int k = 0; k < kPoses; ++k) {
      poses_.push_back(pose_of(k, random));
      samples_.push_back({poses_.back().state.t, random.vec(1), random.vec(10)});
      device.poll();
      device.say(poses_.back());
      device.say(samples_.back());
      if (k % (kPoses / 2) == 0) say_points(device, random);
      usleep(5'000);
    }
    others.join();
  }

  // Two parts; the second time some of the points are where they were told before.
  void say_points(Device& device, testing::Random& random) {
    for (uint16_t part = 0; part < 2; ++part) {
      stream::PointsMessage message;
      message.t = 77'000'000'005 + part;
      message.count = stream::kPointsMax;
      for (int i = 0; i < message.count; ++i) {
        stream::Point& point = message.points[i];
        point = {uint32_t(points_told_++ % 250), random.vec(5).cast<float>(),
                 float(random.uniform(0, 1))};
        points_[point.id] = point;
      }
      points_t_ = message.t;
      device.say(message, part, 2);
    }
  }

  std::vector<std::string> heard(const char* topic, const std::string& type) {
    std::string writer;
    const std::vector<std::string> out = lines_of(out_ + topic, writer);
    EXPECT_EQ(writer, type);
    return out;
  }

  std::string out_ = scratch_folder("ros2") + "/heard_";
  std::vector<Pose> poses_;
  std::vector<ImuSample> samples_;
  std::map<uint32_t, stream::Point> points_;  // as last told
  int points_told_ = 0;
  TimeNs points_t_ = 0;
};

void expect_points(const std::map<uint32_t, stream::Point>& said, TimeNs t, const std::string& line,
                   Differences& d) {
  std::istringstream text(line);
  std::string frame, layout;
  EXPECT_EQ(read_stamp(text, frame), t);
  EXPECT_EQ(frame, "odom");
  constexpr int kLayout = 5 + 4 * 4;
  for (int i = 0; i < kLayout; ++i) {
    std::string word;
    text >> word;
    layout += word + " ";
  }
  const std::string size = std::to_string(said.size());
  EXPECT_EQ(layout, "1 " + size + " 16 " + std::to_string(16 * said.size()) +
                        " 4 x 0 7 1 y 4 7 1 z 8 7 1 sigma 12 7 1 ");
  double x = 0;
  for (const auto& [id, point] : said) {
    for (int i = 0; i < 3 && text >> x; ++i) d.add(double(point.p_W(i)), double(float(x)));
    if (text >> x) d.add(double(point.sigma_m), double(float(x)));
  }
  EXPECT_FALSE(text.fail());
}

TEST_F(Ros2, AnotherProgramHearsWhatTheDeviceHasSaid) {
  talk();
  Differences odom, tf, imu, cloud;
  const auto poses = heard("odom",
                           "nav_msgs::msg::dds_::Odometry_ typehash=RIHS01_"
                           "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0;");
  const auto transforms =
      heard("tf",
            "tf2_msgs::msg::dds_::TFMessage_ typehash=RIHS01_"
            "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087;");
  const auto samples = heard("imu",
                             "sensor_msgs::msg::dds_::Imu_ typehash=RIHS01_"
                             "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b;");
  ASSERT_EQ(poses.size(), poses_.size());
  ASSERT_EQ(transforms.size(), poses_.size());
  ASSERT_EQ(samples.size(), samples_.size());
  for (size_t k = 0; k < poses_.size(); ++k) {
    expect_odom(poses_[k], odom_of(poses[k]), odom);
    expect_tf(poses_[k], transforms[k], tf);
    expect_imu(samples_[k], samples[k], imu);
  }
  const auto clouds = heard("map_points",
                            "sensor_msgs::msg::dds_::PointCloud2_ typehash=RIHS01_"
                            "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5;");
  ASSERT_EQ(clouds.size(), 2u);
  expect_points(points_, points_t_, clouds[1], cloud);
  std::printf("largest differences: odom %.2g, tf %.2g, imu %.2g, map_points %.2g\n",
              odom.largest(), tf.largest(), imu.largest(), cloud.largest());
}

}  // namespace
}  // namespace pirvs::systems
