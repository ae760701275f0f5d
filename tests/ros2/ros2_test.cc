// `pirvs ros2` against a program that shares the type's public definition with it, and no more.
// In      PIRVS_BUILD (default build): host/pirvs, ros2/odom_reader.
// Cost    ~8 s.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "board/linux/stream_output.h"
#include "bsp/api/clock.h"
#include "modules/testing.h"
#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

constexpr int kPoses = 200;

std::string build_folder() {
  const char* const folder = std::getenv("PIRVS_BUILD");
  return folder != nullptr ? folder : "build";
}

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

std::vector<Heard> read(const std::string& file, std::string& writer) {
  std::vector<Heard> out;
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("writer ", 0) == 0) {
      writer = line.substr(7);
      continue;
    }
    std::istringstream text(line);
    Heard one;
    int64_t sec = 0, nanosec = 0;
    text >> sec >> nanosec >> one.frame >> one.child;
    one.t = sec * 1'000'000'000 + nanosec;
    for (double& x : one.pose) text >> x;
    for (double& x : one.pose_cov) text >> x;
    for (double& x : one.twist) text >> x;
    for (double& x : one.twist_cov) text >> x;
    EXPECT_FALSE(text.fail()) << line;
    out.push_back(one);
  }
  return out;
}

void expect_said(const Pose& pose, const Heard& heard) {
  EXPECT_EQ(heard.t, pose.state.t);
  EXPECT_EQ(heard.frame, "odom");
  EXPECT_EQ(heard.child, "base_link");
  const Mat3& R = pose.state.T_WB.R;
  const Vec3 v_B = R.transpose() * pose.state.v_WB;
  Vec4 q = quat_xyzw(R);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(heard.pose[3 + i], q(i), 1e-6) << "floats on the way";
  const auto cov = [&](const double(&from)[36], int i, int j) { return from[i * 6 + j]; };
  const Mat3 attitude = R * pose.cov.block<3, 3>(kTheta, kTheta) * R.transpose();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(heard.pose[i], pose.state.T_WB.p(i), 1e-9);
    EXPECT_NEAR(heard.twist[i], v_B(i), 1e-5);
    EXPECT_NEAR(heard.twist[3 + i], pose.w_B(i), 1e-6);
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(cov(heard.pose_cov, i, j), pose.cov(kPos + i, kPos + j), 1e-6);
      EXPECT_NEAR(cov(heard.pose_cov, 3 + i, 3 + j), attitude(i, j), 1e-6);
      EXPECT_EQ(cov(heard.twist_cov, i, 3 + j), 0);
    }
  }
}

TEST(ros2, another_program_hears_odom_as_the_device_has_said_it) {
  const auto app = std::make_unique<App>();
  board::StreamOutput device;
  ASSERT_EQ(device.open({}, *app, [](board::VisitValue, void*) {}), nullptr);
  const std::string out = scratch_folder("ros2") + "/heard";
  const std::string domain = std::to_string(100 + getpid() % 100);
  const std::string command =
      build_folder() + "/host/pirvs ros2 127.0.0.1:" + std::to_string(device.port().value()) +
      " --device-time --domain " + domain + " --duration 9 2> " + out + ".log & sleep 1; " +
      build_folder() + "/ros2/odom_reader " + domain + " 8 > " + out;
  std::thread others([&] { EXPECT_EQ(std::system(command.c_str()), 0); });
  testing::Random random(1);
  std::vector<Pose> said;
  for (const TimeNs begin = bsp::now(); bsp::now() - begin < 4'000'000'000;) {
    device.poll();  // until both have found each other
    usleep(5'000);
  }
  for (int k = 0; k < kPoses; ++k) {
    said.push_back(pose_of(k, random));
    device.poll();
    device.pose(said.back());
    usleep(5'000);
  }
  others.join();
  device.close();
  std::string writer;
  const std::vector<Heard> heard = read(out, writer);
  EXPECT_EQ(writer,
            "nav_msgs::msg::dds_::Odometry_ typehash=RIHS01_"
            "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0;");
  ASSERT_EQ(heard.size(), said.size());
  for (int k = 0; k < kPoses; ++k) expect_said(said[k], heard[k]);
}

}  // namespace
}  // namespace pirvs::systems
