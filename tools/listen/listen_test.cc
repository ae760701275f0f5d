// The device's end of the stream and the host's, in one program over loopback.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "board/linux/stream_output.h"
#include "bsp/api/clock.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/trajectory.h"
#include "tools/listen/stream_log.h"

namespace pirvs::tools {
namespace {

constexpr TimeNs kMilli = 1'000'000;

constexpr uint32_t kEverything = ~0u;

class listen : public testing::Test {
 protected:
  void SetUp() override {
    app_ = std::make_unique<App>();
    const char* const why = device_.open({}, *app_, [](board::VisitValue visit, void* context) {
      for (int i = 0; i < 200; ++i) {
        visit(context, ("counter_" + std::to_string(i)).c_str(), static_cast<uint64_t>(i));
      }
    });
    ASSERT_EQ(why, nullptr) << why;
    folder_ = testing::TempDir() + "listen_test";
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { device_.close(); }

  std::string address() const { return "127.0.0.1:" + std::to_string(device_.port().value()); }

  // Until the device has heard the listener's request.
  void subscribe(Listener& listener, StreamLog& log) {
    Datagram datagram;
    for (int i = 0; i < 100 && !listener.clock().known; ++i) {
      if (listener.next(datagram, kMilli)) log.add(datagram);
      device_.poll();
    }
    ASSERT_TRUE(listener.clock().known);
  }
  static void drain(Listener& listener, StreamLog& log) {
    Datagram datagram;
    while (listener.next(datagram, 20 * kMilli)) log.add(datagram);
  }
  static Pose pose_at(TimeNs t) {
    Pose pose;
    pose.state.t = t;
    pose.state.T_WB.p.x() = 1e-9 * double(t);
    pose.health = HealthState::kTracking;
    pose.trust.confidence = 1;
    return pose;
  }

  std::unique_ptr<App> app_;
  board::StreamOutput device_;
  std::string folder_;
};

TEST_F(listen, makes_a_run_folder_of_what_the_device_tells) {
  StreamLog log(folder_ + "/run");
  Listener listener(address(), kEverything);
  subscribe(listener, log);
  for (int i = 0; i < 100; ++i) device_.pose(pose_at(i * 5 * kMilli));
  device_.health(7, HealthState::kLost, "no images");
  device_.event({{123, {}, true}, true, pose_at(123)});
  bsp::Pps clock;  // 50 ppm slower than ours
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(clock.add(i * TimeNs{1'000'050'000}));
  device_.pps(clock);
  FusedPose fused;
  fused.t = 42 * kMilli;
  fused.T_EB.p = Vec3(3, 4, 5);
  fused.health = FusionHealth::kFused;
  fused.sources = kFromSlam | kFromGnss;
  for (int i = 0; i < 2; ++i) device_.fused(fused);  // the same time twice: a fix that came late
  device_.imu({43 * kMilli, Vec3(1, 2, 3), Vec3(4, 5, 6)});
  static uint8_t pixels[64 * 48];
  for (size_t i = 0; i < sizeof pixels; ++i) pixels[i] = static_cast<uint8_t>(i);
  StereoFrame frame;
  frame.t = 99;
  frame.present = 1;
  frame.image[0] = {pixels, 64, 48, 64};
  device_.frame(frame);
  drain(listener, log);
  EXPECT_EQ(log.totals().lost, 0u);
  EXPECT_EQ(log.totals().damaged, 0u);
  EXPECT_EQ(log.poses().size(), 100u);
  EXPECT_EQ(log.counters().size(), 200u) << "in parts";
  EXPECT_EQ(log.counters().at("counter_177"), 177u);
  log.write("test", listener.clock());
  const Trajectory trajectory = read_trajectory(folder_ + "/run/trajectory.tum");
  ASSERT_EQ(trajectory.poses.size(), 100u);
  EXPECT_EQ(trajectory.poses[99].t, 495 * kMilli);
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/run/thumbnails/99.png"));
  const Trajectory earth = read_trajectory(folder_ + "/run/fused.tum");
  ASSERT_EQ(earth.poses.size(), 1u);
  EXPECT_EQ(earth.poses[0].t, fused.t);
  EXPECT_EQ(earth.poses[0].p_WB, fused.T_EB.p);
  std::ifstream table(folder_ + "/run/fused.csv");
  const std::string rows((std::istreambuf_iterator<char>(table)), {});
  EXPECT_NE(rows.find("slam+gnss,fused,"), std::string::npos) << rows;
  EXPECT_EQ(log.totals().of_kind[size_t(stream::Kind::kImu)], 1u);
  std::ifstream summary(folder_ + "/run/summary.json");
  const auto json = nlohmann::json::parse(summary);
  EXPECT_EQ(json["poses"], 100);
  EXPECT_EQ(json["sync_in_edges"], 1);
  EXPECT_NEAR(json["external_clock"]["rate_ppb"].get<double>(), 50'000, 1);
  EXPECT_EQ(json["external_clock"]["second_t_ns"], 4 * 1'000'050'000LL);
  std::ifstream pulses(folder_ + "/run/pps.csv");
  std::string heading, row;
  ASSERT_TRUE(std::getline(pulses, heading) && std::getline(pulses, row));
  EXPECT_EQ(row, "4000200000,50000.0,0,5,0");
  EXPECT_NEAR(json["path_m"].get<double>(), 0.495, 1e-9);
  // Both ends are this machine.
  EXPECT_LT(std::abs(listener.clock().offset_ns), listener.clock().round_trip_ns);
}

TEST_F(listen, counts_what_was_lost_on_the_way) {
  StreamLog log;
  Listener listener(address(), stream::bit(stream::Kind::kPose));
  subscribe(listener, log);
  uint8_t gone = 0;
  for (int i = 0; i < 50; ++i) device_.pose(pose_at(i * kMilli));
  Datagram datagram;
  while (listener.next(datagram, 20 * kMilli)) {
    if (++gone % 10 != 0) log.add(datagram);
  }
  EXPECT_EQ(log.totals().lost, 4u) << "the last one has none after it that would tell";
}

TEST_F(listen, a_recorded_stream_reads_back_the_same) {
  const std::string file = folder_ + "/stream";
  {
    StreamLog log;
    Listener listener(address(), kEverything);
    listener.record(file);
    subscribe(listener, log);
    for (int i = 0; i < 10; ++i) device_.pose(pose_at(i));
    drain(listener, log);
  }
  StreamLog log;
  Listener from_file(file, 0);
  EXPECT_FALSE(from_file.live());
  drain(from_file, log);
  EXPECT_TRUE(from_file.ended());
  EXPECT_EQ(log.poses().size(), 10u);
  // Cut off in the middle of the last datagram.
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 3);
  StreamLog cut;
  Listener from_cut(file, 0);
  drain(from_cut, cut);
  EXPECT_EQ(cut.poses().size() + cut.totals().of_kind[3], 10u + log.totals().of_kind[3] - 1);
}

TEST_F(listen, a_device_serves_four_and_refuses_the_fifth) {
  std::vector<std::unique_ptr<Listener>> listeners;
  StreamLog log;
  for (int i = 0; i < 5; ++i) {
    listeners.push_back(std::make_unique<Listener>(address(), kEverything));
    subscribe(*listeners.back(), log);
  }
  EXPECT_GE(device_.counters().refused, 1u);
  listeners.erase(listeners.begin());  // it says that it goes
  device_.poll();
  Datagram datagram;
  bool heard_pose = false;
  for (int i = 0; i < 200 && !heard_pose; ++i) {
    device_.poll();
    device_.pose(pose_at(i));
    StreamLog fifth;
    while (listeners.back()->next(datagram, 20 * kMilli)) fifth.add(datagram);
    heard_pose = !fifth.poses().empty();
  }
  EXPECT_TRUE(heard_pose) << "its place is free now";
}

TEST_F(listen, bytes_that_are_no_request_are_counted) {
  const Result<bsp::Socket> socket = bsp::datagram_open({});
  ASSERT_TRUE(socket.ok());
  const bsp::Endpoint to = {bsp::Endpoint{}.address, device_.port().value()};
  for (const char* bytes : {"", "PVS1", "GET / HTTP/1.1"}) {
    (void)bsp::datagram_send(socket.value(), to, bytes, std::strlen(bytes));
  }
  for (int i = 0; i < 100 && device_.counters().bad_requests < 3; ++i) device_.poll();
  EXPECT_EQ(device_.counters().bad_requests, 3u);
  bsp::datagram_close(socket.value());
}

TEST(listen_to, what_is_not_there_is_told) {
  EXPECT_THROW(Listener("no.such.device.invalid", 0), InputError);
  const std::string file = testing::TempDir() + "no_stream";
  std::ofstream(file) << "something else, long enough";
  EXPECT_THROW(Listener(file, 0), InputError);
}

}  // namespace
}  // namespace pirvs::tools
