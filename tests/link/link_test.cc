// The robot's link against a program that shares no code with it: client.cjs, over node-mavlink.
// In      PIRVS_BUILD (default build): host/pirvs, and link/node_modules, which make fetches.
// Cost    70 s, of which 36 s are two recordings in real time.
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>

#include "modules/link/link.h"
#include "modules/testing.h"
#include "tests/programs.h"
#include "tests/recordings.h"
#include "tools/dataset/trajectory.h"

namespace pirvs::systems {
namespace {

using nlohmann::json;
using namespace nlohmann::literals;

std::string client(const std::string& arguments) {
  return "NODE_PATH=" + build_folder() + "/link/node_modules node tests/link/client.cjs " +
         arguments;
}

std::string pirvs_run(const std::string& sequence, const std::string& out,
                      const std::string& options) {
  return build_folder() + "/host/pirvs run " + sequence + " --out " + out + " " + options;
}

std::string content(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

int udp_socket(uint16_t port, sockaddr_in& address) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return fd;
}

// One that nobody has at the moment.
int free_port() {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  const int fd = udp_socket(0, address);
  EXPECT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size), 0);
  close(fd);
  return ntohs(address.sin_port);
}

// ---- every field -------------------------------------------------------------------------------

Pose random_pose(testing::Random& random, int k) {
  Pose pose;
  pose.state = random.state();
  pose.state.t = 1'000'000'000'000 + k * TimeNs{20'000'000};
  pose.t_frame = pose.state.t;
  pose.w_B = random.vec(1);
  Mat9 root;
  for (int i = 0; i < 81; ++i) root(i / 9, i % 9) = random.gauss(0.05);
  pose.cov = root * root.transpose();
  pose.health = HealthState::kTracking;
  pose.trust.confidence = static_cast<float>((k % 100 + 1) / 100.0);
  pose.trust.resets = static_cast<uint32_t>(k / 10 + 250);
  if (k % 7 == 3) pose.cov(kVel, kVel) += 4;  // a velocity that is no better than none
  return pose;
}

template <class Matrix>
json rows(const Matrix& m) {
  json out = json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index j = 0; j < m.cols(); ++j) row.push_back(m(i, j));
    out.push_back(row);
  }
  return out;
}

json truth_of(const Pose& pose, int k, int frame) {
  const auto list = [](const Vec3& v) { return json{v.x(), v.y(), v.z()}; };
  return {
      {"t_us", pose.state.t / 1000}, {"p", list(pose.state.T_WB.p)}, {"R", rows(pose.state.T_WB.R)},
      {"v", list(pose.state.v_WB)},  {"w", list(pose.w_B)},          {"cov", rows(pose.cov)},
      {"quality", k % 100 + 1},      {"resets", pose.trust.resets},  {"frame", frame},
      {"has_velocity", k % 7 != 3}};
}

TEST(link, another_program_reads_every_field_as_it_was_meant) {
  for (const auto& [frame, number] :
       {std::pair(LinkFrame::kLocalFrd, 20), std::pair(LinkFrame::kLocalNed, 1)}) {
    const std::string folder = scratch_folder("link_file");
    std::ofstream log(folder + "/log.tlog", std::ios::binary);
    const auto write = [](void* to, const uint8_t* bytes, size_t size) {
      const uint64_t stamp = __builtin_bswap64(1'000'000'000);
      static_cast<std::ofstream*>(to)->write(reinterpret_cast<const char*>(&stamp), 8);
      static_cast<std::ofstream*>(to)->write(reinterpret_cast<const char*>(bytes),
                                             static_cast<std::streamsize>(size));
      return true;
    };
    LinkSetup setup;
    setup.system = 7;
    setup.frame = frame;
    Link link;
    link.configure(setup, ImuNoise{}, {}, {&log, write});
    testing::Random random(1);
    json truth = json::array();
    for (int k = 0; k < 200; ++k) {
      const Pose pose = random_pose(random, k);
      truth.push_back(truth_of(pose, k, number));
      link.pose(pose);
      link.poll(pose.state.t);
    }
    link.health(HealthState::kLost, "no images");
    log.close();
    std::ofstream(folder + "/truth.json") << truth;
    const json heard =
        json::parse(said_by(client("file " + folder + "/log.tlog " + folder + "/truth.json")));
    EXPECT_EQ(heard["odometry"], 200);
    EXPECT_EQ(heard["failures"], 0);
    EXPECT_EQ(heard["heartbeats"], 4);
    EXPECT_EQ(heard["texts"], json{"PIRVS lost: no images"});
  }
}

// ---- a whole recording in real time ------------------------------------------------------------

struct Talk {
  json client;   // what it has heard
  json summary;  // of the run

  // False: other programs had this machine, and poses came long after their samples.
  bool kept_real_time() const {
    constexpr double kLate_ms = 50;
    return summary.value("/latency_ms/imu_to_pose/max"_json_pointer, kLate_ms) < kLate_ms;
  }
};

Talk talk_once(const std::string& sequence, const std::string& options) {
  const std::string folder = scratch_folder("link_live");
  const int port = free_port();
  Talk out;
  std::string heard;
  std::thread listening([&] {
    heard = said_by(client("live " + std::to_string(port) + " 2> " + folder + "/client.log"));
  });
  usleep(500'000);  // until it listens; what it misses before is no loss
  const std::string to = " --mavlink udp:127.0.0.1:" + std::to_string(port);
  // 1: lost at the end, as it may be on a machine that is too slow.
  said_by(pirvs_run(sequence, folder + "/run", "--realtime --cores 2 " + options + to) +
          " || test $? = 1");
  listening.join();
  out.client = json::parse(heard, nullptr, false);
  out.summary = json::parse(content(folder + "/run/summary.json"));
  std::printf("%s\n", heard.c_str());
  return out;
}

Talk talk(const std::string& sequence, const std::string& options) {
  Talk out = talk_once(sequence, options);
  if (!out.kept_real_time()) out = talk_once(sequence, options);
  return out;
}

// Whatever else this machine does.
void expect_good_messages(const json& heard) {
  ASSERT_TRUE(heard.is_object());
  EXPECT_LE(heard["length_error_max"], 1e-5);
  EXPECT_EQ(heard["covariances_bad"], 0);
  EXPECT_EQ(heard["checksums_wrong"], 0);
  EXPECT_EQ(heard["frames"], json{"20/12/3"});
  for (const int quality : heard["qualities"]) {
    EXPECT_TRUE(quality == -1 || (quality >= 1 && quality <= 100)) << quality;
  }
}

void expect_a_whole_talk(const json& heard) {
  expect_good_messages(heard);
  EXPECT_LE(heard["gap_ms_max"], 100) << "between the poses' own times";
  // Both are programs of this machine, and may have to wait for a processor.
  EXPECT_LT(heard["trips_ms"]["median"], 1);
  EXPECT_LT(heard["clock_ahead_ms_max"], 200) << "the clock that is told is not the poses'";
}

TEST(link, an_autopilot_hears_sets_the_pose_and_is_heard) {
  const Talk talked = talk(simulated(SimulatedDevice::kIronsides).folder, "");
  const json& heard = talked.client;
  expect_good_messages(heard);
  if (!talked.kept_real_time()) GTEST_SKIP() << "this machine could not keep real time";
  expect_a_whole_talk(heard);
  EXPECT_GT(heard["odometry"], 200);
  // Told where it is: the pose jumps there, and says that it did.
  ASSERT_EQ(heard["resets"].size(), 2u);
  EXPECT_EQ(heard["resets"][1].get<int>() - heard["resets"][0].get<int>(), 1);
  const double place[3] = {10, 20, -3};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(heard["set_pose"]["place"][i], place[i], 0.2);
  EXPECT_NEAR(heard["set_pose"]["yaw_deg"], 90, 10);
  ASSERT_EQ(heard["acks"].size(), 2u);
  for (const json& ack : heard["acks"]) EXPECT_EQ(ack[1], ack[0] == 31011 ? 0 : 3) << ack;
  EXPECT_GT(heard["questions"], 1) << "its clock has been asked for";
  const json& counters = talked.summary["counters"];
  EXPECT_GT(counters["link.fixes"], 10);
  EXPECT_GT(counters["link.wheels"], 10);
  EXPECT_EQ(counters["link.commands"], 2);
  EXPECT_EQ(counters["link.poses_overtaken"], 0);
}

TEST(link, no_gap_over_a_whole_recording_in_real_time) {
  if (clip() == nullptr) GTEST_SKIP() << "the real recording is not on this machine";
  // EuRoC's IMU has x up and z forward.
  const Talk talked = talk(clip()->folder, "--mavlink-set 'mounting_deg=0 -90 180'");
  expect_good_messages(talked.client);
  if (!talked.kept_real_time()) GTEST_SKIP() << "this machine could not keep real time";
  expect_a_whole_talk(talked.client);
  EXPECT_GT(talked.client["odometry"], 1'400);
  EXPECT_LE(talked.client["arrival_gap_ms_max"], 100);
}

// The block of docs/integration.md, as it stands there but for the port.
std::string documented_client(int port) {
  const std::string page = content("docs/integration.md"), begin = "```python\n";
  const size_t from = page.find(begin) + begin.size();
  std::string text = page.substr(from, page.find("```\n", from) - from);
  const std::string documented = "14550";
  text.replace(text.find(documented), documented.size(), std::to_string(port));
  return text;
}

TEST(link, the_client_of_the_documentation_reads_poses) {
  const std::string folder = scratch_folder("link_client");
  const int port = free_port();
  std::ofstream(folder + "/client.py") << documented_client(port);
  const std::string options = "--mavlink udp:127.0.0.1:" + std::to_string(port);
  said_by("python3 " + folder + "/client.py > " + folder + "/said & client=$!; sleep 0.5; " +
          pirvs_run(simulated(SimulatedDevice::kIronsides).folder, folder + "/run", options) +
          "; status=$?; sleep 0.2; kill $client; exit $status");
  const tools::Trajectory truth = tools::read_trajectory(folder + "/run/trajectory.tum");
  std::istringstream said(content(folder + "/said"));
  size_t lines = 0, compared = 0, at = 0;
  int64_t usec = 0;
  double p[3], q[4];
  int resets = 0, quality = 0;
  while (said >> usec >> p[0] >> p[1] >> p[2] >> q[0] >> q[1] >> q[2] >> q[3] >> resets >>
         quality) {
    ++lines;
    EXPECT_GE(quality, 1);
    const TimeNs t = usec * 1000;
    while (at + 1 < truth.poses.size() && truth.poses[at].t < t) ++at;
    if (std::abs(truth.poses[at].t - t) > 3'000'000) continue;
    ++compared;
    const Vec3& p_WB = truth.poses[at].p_WB;
    EXPECT_LT((p_WB - Vec3(p[0], -p[1], -p[2])).norm(), 0.05) << usec;
    const Vec4& xyzw = truth.poses[at].q_WB;
    const double cosine_of_half = xyzw(3) * q[0] + xyzw(0) * q[1] - xyzw(1) * q[2] - xyzw(2) * q[3];
    EXPECT_GT(std::abs(cosine_of_half), 0.999) << usec;
  }
  EXPECT_GT(lines, 200u);
  EXPECT_GT(compared, 30u);
}

// ---- what the other side does costs nothing ----------------------------------------------------

TEST(link, trajectories_are_the_same_bytes_whoever_listens_floods_or_is_away) {
  const std::string sequence = simulated(SimulatedDevice::kEuroc).folder;
  const std::string out = scratch_folder("link_bytes");
  const std::string part = "--duration 3 ";
  said_by(pirvs_run(sequence, out + "/plain", part));
  const std::string plain = content(out + "/plain/trajectory.tum");
  ASSERT_GT(plain.size(), 1'000u);
  said_by(pirvs_run(sequence, out + "/file", part + "--mavlink " + out + "/log.tlog"));
  EXPECT_TRUE(content(out + "/file/trajectory.tum") == plain);
  const std::string log = content(out + "/log.tlog");
  EXPECT_GT(log.size(), 10'000u);
  said_by(pirvs_run(sequence, out + "/again", part + "--mavlink " + out + "/again.tlog"));
  EXPECT_TRUE(content(out + "/again.tlog") == log) << "the same input, the same bytes";
  const std::string nobody = "--mavlink udp:127.0.0.1:" + std::to_string(free_port());
  said_by(pirvs_run(sequence, out + "/away", part + nobody));
  EXPECT_TRUE(content(out + "/away/trajectory.tum") == plain);

  const auto robot_port = static_cast<uint16_t>(free_port()),
             own = static_cast<uint16_t>(free_port());
  std::atomic<bool> stop{false};
  std::thread flood([&] {
    sockaddr_in to{};
    const int fd = udp_socket(own, to);
    testing::Random random(3);
    uint8_t bytes[1400];
    for (uint8_t& byte : bytes)
      byte = random.uniform(0, 1) < 0.2 ? 0xFD : static_cast<uint8_t>(random.uniform(0, 255));
    while (!stop)
      (void)sendto(fd, bytes, sizeof bytes, 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
    close(fd);
  });
  said_by(pirvs_run(sequence, out + "/flood",
                    part + "--mavlink udp:127.0.0.1:" + std::to_string(robot_port) +
                        " --mavlink-set own_port=" + std::to_string(own)));
  stop = true;
  flood.join();
  EXPECT_TRUE(content(out + "/flood/trajectory.tum") == plain);
  const json summary = json::parse(content(out + "/flood/summary.json"));
  EXPECT_GT(summary["counters"]["link.bytes_skipped"], 10'000);
}

}  // namespace
}  // namespace pirvs::systems
