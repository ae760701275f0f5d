// The link's wires: datagrams over loopback, and a pseudo terminal that may be pulled.
#include "board/linux/robot_link.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "board/linux/testing_line_test.h"
#include "bsp/api/clock.h"
#include "bsp/replay/sensors.h"

namespace pirvs::board {
namespace {

using namespace mavlink;

constexpr TimeNs kMilli = 1'000'000;

class RobotLinkTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const Result<bsp::Socket> robot = bsp::datagram_open({});
    ASSERT_TRUE(robot.ok());
    robot_ = robot.value();
  }
  void TearDown() override {
    link_.close();
    bsp::datagram_close(robot_);
  }

  void open_udp() {
    LinkSettings settings;
    settings.has_udp = true;
    settings.udp.port = bsp::datagram_port(robot_).value();
    ASSERT_EQ(link_.open(settings, ImuNoise{}, *app_, bsp::now), nullptr);
  }
  void open_serial() {
    LinkSettings settings;
    ASSERT_EQ(read_text(line_.path(), settings.serial), nullptr);
    settings.baud = 921'600;
    ASSERT_EQ(link_.open(settings, ImuNoise{}, *app_, now_of_test), nullptr);
  }
  static TimeNs now_of_test() { return now_; }
  void poll_at(TimeNs t) {
    now_ = t;
    link_.poll();
  }

  void publish(TimeNs t) {
    Pose pose;
    pose.state.t = t;
    pose.health = HealthState::kTracking;
    pose.trust.confidence = 1;
    app_->poses().publish(pose);
  }
  // Frames that have come to the robot, by its socket or its end of the line.
  std::vector<Frame> heard() {
    std::vector<Frame> out;
    uint8_t bytes[bsp::kDatagramMax];
    size_t size = 0;
    bsp::Endpoint from;
    while (bsp::datagram_receive(robot_, bytes, sizeof bytes, size, from) == Status::kOk) {
      from_ = from;
      take(bytes, size, out);
    }
    const std::string line = line_.heard();
    take(reinterpret_cast<const uint8_t*>(line.data()), line.size(), out);
    return out;
  }
  void take(const uint8_t* bytes, size_t size, std::vector<Frame>& out) {
    for (size_t at = 0; at < size;) {
      at += parser_.push(bytes + at, size - at);
      for (Frame frame; parser_.next(frame);) out.push_back(frame);
    }
  }
  template <class Message>
  int count(const std::vector<Frame>& frames) {
    int out = 0;
    for (const Frame& frame : frames) out += frame.id == Message::kKind.id;
    return out;
  }
  template <class Message>
  void say(const Message& message, bsp::Socket from) {
    Sender sender{1, 1, 0};
    uint8_t bytes[kFrameMax];
    const size_t size = encode(message, sender, bytes);
    EXPECT_EQ(bsp::datagram_send(from, {bsp::Endpoint{}.address, link_.port()}, bytes, size),
              Status::kOk);
  }

  static inline TimeNs now_ = 0;
  std::unique_ptr<App> app_ = std::make_unique<App>();
  RobotLink link_;
  bsp::Socket robot_;
  bsp::Endpoint from_;
  TestingLine line_{"pirvs_link_tty_"};
  FrameParser parser_;
};

TEST_F(RobotLinkTest, ATimeIsToldWhileAThreadServesTheLink) {
  open_udp();
  ASSERT_EQ(link_.start_thread(), nullptr);
  for (int i = 0; i < 200 && link_.port() == 0; ++i) usleep(1'000);
  ASSERT_NE(link_.port(), 0);
  std::vector<Frame> all;
  for (int i = 0; i < 50; ++i) {
    publish(bsp::now());
    link_.health(HealthState::kTracking, "from core 0");
    Timesync question;
    question.ts1_ns = bsp::now();
    say(question, robot_);
    usleep(20'000);
    for (const Frame& frame : heard()) all.push_back(frame);
  }
  link_.close();
  for (const Frame& frame : heard()) all.push_back(frame);
  EXPECT_EQ(count<Odometry>(all), 50);
  EXPECT_EQ(count<StatusText>(all), 50);
  EXPECT_EQ(count<Timesync>(all), 50);
  TimeNs trip = INT64_MAX;
  for (const Frame& frame : all) {
    Timesync answer;
    if (decode(frame, answer)) trip = std::min(trip, answer.tc1_ns - answer.ts1_ns);
  }
  EXPECT_GE(trip, 0);
  EXPECT_LT(trip, 5 * kMilli);
}

TEST_F(RobotLinkTest, TheStackAnswersTheRobotsCommands) {
  open_udp();
  link_.poll();
  CommandLong command;
  command.command = kCommandReset;
  command.target_system = 1;
  command.target_component = kComponent;
  say(command, robot_);
  link_.poll();
  EXPECT_EQ(count<CommandAck>(heard()), 0);
  link_.answer({1, CommandKind::kReset, Status::kOk});  // the inbox's first ticket
  link_.poll();
  EXPECT_EQ(count<CommandAck>(heard()), 1);
}

TEST_F(RobotLinkTest, StrangersAreNotHeard) {
  open_udp();
  link_.poll();
  const Result<bsp::Socket> stranger = bsp::datagram_open({0x7f00'0002, 0});  // 127.0.0.2
  ASSERT_TRUE(stranger.ok());
  say(Timesync{}, stranger.value());
  link_.poll();
  bsp::datagram_close(stranger.value());
  EXPECT_EQ(count<Timesync>(heard()), 0);
  uint32_t strangers = 0;
  link_.for_each_counter([&](const char* name, uint32_t value) {
    if (std::string(name) == "strangers") strangers = value;
  });
  EXPECT_EQ(strangers, 1u);
  EXPECT_EQ(from_.address, bsp::Endpoint{}.address) << "bound to loopback, as the robot is";
}

TEST_F(RobotLinkTest, ASerialLineThatIsNotReadLosesWholeFrames) {
  line_.plug();
  open_serial();
  TimeNs t = 1'000 * kMilli;
  for (int i = 0; i < 2'000; ++i) {
    t += 20 * kMilli;
    publish(t);
    poll_at(t);
  }
  std::vector<Frame> frames = heard();
  EXPECT_GT(count<Odometry>(frames), 3);
  EXPECT_LT(count<Odometry>(frames), 1'000);
  const int before = count<Odometry>(frames);
  for (int i = 0; i < 100; ++i) {
    t += 20 * kMilli;
    publish(t);
    poll_at(t);
    for (const Frame& frame : heard()) frames.push_back(frame);
  }
  EXPECT_GE(count<Odometry>(frames) - before, 98) << "and goes on";
  EXPECT_EQ(parser_.counters().bytes_skipped, 0u) << "no frame was cut";
}

TEST_F(RobotLinkTest, ALineThatComesAndGoesIsTakenUpAgain) {
  open_serial();
  TimeNs t = 1'000 * kMilli;
  const auto run = [&](int frames) {
    int out = 0;
    for (int i = 0; i < frames; ++i) {
      t += 20 * kMilli;
      publish(t);
      poll_at(t);
      out += count<Odometry>(heard());
    }
    return out;
  };
  EXPECT_EQ(run(50), 0) << "it is not there yet";
  line_.plug();
  EXPECT_GT(run(100), 70) << "half a second until it is looked for";
  line_.unplug();
  EXPECT_EQ(run(50), 0);
  line_.plug();
  EXPECT_GT(run(100), 70);
}

TEST_F(RobotLinkTest, AFloodIsHeardAPieceAtATime) {
  open_udp();
  link_.poll();
  const std::vector<uint8_t> noise(1'400, 0xFD);
  for (int i = 0; i < 100; ++i) {
    (void)bsp::datagram_send(robot_, {bsp::Endpoint{}.address, link_.port()}, noise.data(),
                             noise.size());
  }
  const auto skipped = [this] {
    uint32_t out = 0;
    link_.for_each_counter([&](const char* name, uint32_t value) {
      if (std::string(name) == "bytes_skipped") out = value;
    });
    return out;
  };
  link_.poll();
  const uint32_t once = skipped();
  EXPECT_GT(once, 1'000u);
  EXPECT_LE(once, RobotLink::kBytesAtOnce + noise.size());
  link_.poll();
  EXPECT_GT(skipped(), once);
}

// The whole way: bytes of the line, the door, fusion.
TEST_F(RobotLinkTest, AFixOfTheRobotsReachesFusion) {
  constexpr TimeNs kBegin = 1'000'000 * kMilli;
  int sample = 0;  // of a second
  bsp::RecordingSource imu{};
  imu.context = &sample;
  imu.next_imu = [](void* context, ImuSample& out) {
    int& k = *static_cast<int*>(context);
    out = {kBegin + 5 * kMilli * k, Vec3::Zero(), Vec3(0, 0, 9.81)};
    return k++ < 200;
  };
  imu.next_frame = [](void*, StereoFrame&) { return false; };
  imu.release_frame = [](void*, FrameId) {};
  bsp::play(imu, bsp::ReplayPace::kFast);
  Calibration calibration;
  for (Camera& camera : calibration.camera) {
    camera.width = 320;
    camera.height = 240;
    camera.fx = camera.fy = 200;
    camera.cx = 160;
    camera.cy = 120;
  }
  std::vector<FixGate> gates;
  std::vector<FusedPose> fused;
  struct Heard {
    std::vector<FixGate>& gates;
    std::vector<FusedPose>& fused;
  } heard_by_sinks{gates, fused};
  AppSinks sinks;
  sinks.context = &heard_by_sinks;
  sinks.fix = [](void* to, const GnssFix&, FixGate gate) {
    static_cast<Heard*>(to)->gates.push_back(gate);
  };
  sinks.fused = [](void* to, const FusedPose& pose) {
    static_cast<Heard*>(to)->fused.push_back(pose);
  };
  app_->configure(calibration, AppParams{}, sinks);
  line_.plug();
  open_serial();
  poll_at(kBegin + 400 * kMilli);
  GpsInput fix;
  fix.lat_1e7_deg = 473'977'000;
  fix.lon_1e7_deg = 85'456'000;
  fix.alt_m = 488;
  fix.fix_type = 3;
  fix.horiz_accuracy_m = 1.5f;
  fix.vert_accuracy_m = 3;
  fix.ignore_flags = GpsInput::kNoSpeed;
  GpsRawInt raw;
  raw.lat_1e7_deg = fix.lat_1e7_deg + 10;
  raw.lon_1e7_deg = fix.lon_1e7_deg;
  raw.alt_mm = raw.alt_ellipsoid_mm = 488'000;
  raw.fix_type = 3;
  raw.h_acc_mm = 1'500;
  raw.v_acc_mm = 3'000;
  Sender sender{1, 1, 0};
  const auto tell = [&](const auto& message, TimeNs t) {
    uint8_t bytes[kFrameMax];
    const size_t size = encode(message, sender, bytes);
    line_.type(std::string(reinterpret_cast<const char*>(bytes), size));
    poll_at(t);
  };
  tell(fix, kBegin + 500 * kMilli);
  tell(raw, kBegin + 700 * kMilli);
  (void)app_->run(CorePlan{}, Drive::kLockstep);
  EXPECT_EQ(gates, (std::vector<FixGate>{FixGate::kAccepted, FixGate::kAccepted}));
  ASSERT_EQ(fused.size(), 2u);
  EXPECT_EQ(fused[0].t, kBegin + 500 * kMilli);
  EXPECT_NEAR(fused[0].place.height_m, 488, 1e-3);
  EXPECT_EQ(fused[1].t, kBegin + 700 * kMilli);
}

}  // namespace
}  // namespace pirvs::board
