#include "modules/link/link.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "core/math/trig.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using namespace mavlink;

constexpr TimeNs kMilli = 1'000'000, kSecond = 1'000'000'000;

Pose random_pose(testing::Random& random) {
  Pose pose;
  pose.state = random.state();
  pose.state.t = 5 * kSecond;
  pose.t_frame = pose.state.t - 20 * kMilli;
  pose.w_B = random.vec(1);
  Mat9 root;
  for (int i = 0; i < 81; ++i) root(i / 9, i % 9) = random.gauss(0.03);
  pose.cov = root * root.transpose() + 1e-4 * Mat9::Identity();
  pose.health = HealthState::kTracking;
  pose.trust.confidence = 0.8f;
  return pose;
}

// ---- the link ----------------------------------------------------------------------------------

class robot_link : public ::testing::Test {
 protected:
  void SetUp() override { configure({}); }
  void configure(const LinkSetup& setup) {
    LinkStack stack;
    stack.context = this;
    stack.command = [](void* self, const Command& command) -> Result<uint32_t> {
      auto& test = *static_cast<robot_link*>(self);
      if (test.inbox_full_) return Status::kFull;
      test.commands_.push_back(command);
      return static_cast<uint32_t>(test.commands_.size() - 1);
    };
    stack.deliver = [](void* self, const Arrival& arrival) {
      auto& test = *static_cast<robot_link*>(self);
      if (test.inbox_full_) return Status::kFull;
      test.arrivals_.push_back(arrival);
      return Status::kOk;
    };
    const LinkWire wire = {this, [](void* self, const uint8_t* bytes, size_t size) {
                             auto& test = *static_cast<robot_link*>(self);
                             if (test.wire_full_) return false;
                             EXPECT_EQ(test.parser_.push(bytes, size), size);
                             Frame frame;
                             EXPECT_TRUE(test.parser_.next(frame)) << "one whole frame a call";
                             test.frames_.push_back(frame);
                             return true;
                           }};
    link_.configure(setup, ImuNoise{}, stack, wire);
  }

  template <class Message>
  void say(TimeNs now, const Message& message, uint8_t system = 1, uint8_t component = 1) {
    Sender sender{system, component, 0};
    uint8_t bytes[kFrameMax];
    const size_t size = encode(message, sender, bytes);
    link_.receive(now, bytes, size);
  }
  template <class Message>
  std::vector<Message> heard() const {
    std::vector<Message> out;
    for (const Frame& frame : frames_) {
      Message message;
      if (decode(frame, message)) out.push_back(message);
    }
    return out;
  }
  static CommandLong ask(uint16_t command) {
    CommandLong out;
    out.command = command;
    out.target_system = 1;
    out.target_component = kComponent;
    return out;
  }

  Link link_;
  FrameParser parser_;
  std::vector<Frame> frames_;
  std::vector<Command> commands_;
  std::vector<Arrival> arrivals_;
  bool inbox_full_ = false, wire_full_ = false;
};

TEST_F(robot_link, tells_all_of_a_pose) {
  testing::Random random(5);
  Pose pose = random_pose(random);
  pose.trust.resets = 259;
  link_.pose(pose);
  const auto heard_ = heard<Odometry>();
  ASSERT_EQ(heard_.size(), 1u);
  const Odometry& out = heard_[0];
  const VehiclePose vehicle = vehicle_pose(pose, Mat3::Identity());
  EXPECT_EQ(frames_[0].component, 197);
  EXPECT_EQ(out.time_usec, 5'000'000u);
  EXPECT_EQ(out.frame_id, 20);
  EXPECT_EQ(out.child_frame_id, 12);
  EXPECT_EQ(out.estimator_type, 3);
  EXPECT_EQ(out.reset_counter, 3) << "the lowest byte";
  EXPECT_EQ(out.quality, 80);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FLOAT_EQ(out.x_m[i], static_cast<float>(vehicle.p_LD(i)));
    EXPECT_FLOAT_EQ(out.v_m_s[i], static_cast<float>(vehicle.v_D(i)));
    EXPECT_FLOAT_EQ(out.rates_rad_s[i], static_cast<float>(vehicle.w_D(i)));
  }
  int at = 0;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j, ++at) {
      EXPECT_FLOAT_EQ(out.pose_covariance[at], static_cast<float>(vehicle.cov_pose(i, j)));
      if (j < 3) {
        EXPECT_FLOAT_EQ(out.velocity_covariance[at], static_cast<float>(vehicle.cov_v_D(i, j)));
      }
    }
  }
  // 1.7e-4 rad/s/sqrt(Hz) at 200 Hz.
  EXPECT_FLOAT_EQ(out.velocity_covariance[20], 1.7e-4f * 1.7e-4f * 200);
}

TEST_F(robot_link, quaternions_have_length_one_in_float) {
  testing::Random random(17);
  for (int i = 0; i < 2000; ++i) {
    Pose pose = random_pose(random);
    pose.state.t = i * kSecond;
    // A rotation that thousands of products have worn out.
    pose.state.T_WB.R *= 1 + random.gauss(1e-6);
    link_.pose(pose);
  }
  const auto poses = heard<Odometry>();
  ASSERT_EQ(poses.size(), 2000u);
  for (const Odometry& pose : poses) {
    float squares = 0;
    for (const float x : pose.q_wxyz) squares += x * x;
    EXPECT_LE(std::fabs(1 - std::sqrt(squares)), 1e-6f);
  }
}

TEST_F(robot_link, sends_at_the_rate_of_its_setup) {
  for (const double rate_hz : {30.0, 50.0, 100.0}) {
    LinkSetup setup;
    setup.rate_hz = rate_hz;
    configure(setup);
    frames_.clear();
    testing::Random random(1);
    Pose pose = random_pose(random);
    for (int i = 0; i < 2000; ++i) {  // ten seconds, of stamps that vary
      pose.state.t = kSecond + i * 5 * kMilli + static_cast<TimeNs>(random.uniform(-2e5, 2e5));
      link_.pose(pose);
    }
    EXPECT_NEAR(static_cast<double>(heard<Odometry>().size()), 10 * rate_hz, 2);
    const auto poses = heard<Odometry>();
    for (size_t i = 1; i < poses.size(); ++i) {
      EXPECT_LT(poses[i].time_usec - poses[i - 1].time_usec, 1e6 / rate_hz + 5'500);
    }
  }
}

TEST_F(robot_link, goes_on_after_a_gap_and_when_time_runs_back) {
  testing::Random random(1);
  Pose pose = random_pose(random);
  for (const TimeNs t : {10 * kSecond, 20 * kSecond, 3 * kSecond}) {
    frames_.clear();
    pose.state.t = t;
    link_.pose(pose);
    EXPECT_EQ(heard<Odometry>().size(), 1u) << t;
    pose.state.t += 5 * kMilli;
    link_.pose(pose);
    EXPECT_EQ(heard<Odometry>().size(), 1u) << t;
  }
}

TEST_F(robot_link, no_velocity_is_not_a_number) {
  testing::Random random(1);
  Pose pose = random_pose(random);
  pose.cov(kVel + 1, kVel + 1) = 4;
  link_.pose(pose);
  const Odometry out = heard<Odometry>().at(0);
  for (const float v : out.v_m_s) EXPECT_TRUE(std::isnan(v));
  for (const float c : out.velocity_covariance) EXPECT_TRUE(std::isnan(c));
  EXPECT_TRUE(std::isfinite(out.x_m[0]) && std::isfinite(out.pose_covariance[0]));
}

TEST_F(robot_link, quality_is_confidence_and_falls_when_images_stop) {
  testing::Random random(1);
  Pose pose = random_pose(random);
  EXPECT_EQ(link_quality(pose), 80);
  pose.trust.confidence = 1e-4f;
  EXPECT_EQ(link_quality(pose), 1) << "0 means unknown";
  pose.trust.confidence = 0;
  EXPECT_EQ(link_quality(pose), -1);
  pose.trust.confidence = 0.9f;
  pose.dead_reckoning = true;
  pose.t_frame = pose.state.t - kSecond / 2;
  EXPECT_EQ(link_quality(pose), 25);
  pose.t_frame = pose.state.t - 2 * kSecond;
  EXPECT_EQ(link_quality(pose), 10);
  pose.health = HealthState::kLost;
  EXPECT_EQ(link_quality(pose), -1);
}

TEST_F(robot_link, the_frame_is_a_setting_and_so_are_the_older_messages) {
  LinkSetup setup;
  setup.frame = LinkFrame::kLocalNed;
  setup.system = 42;
  configure(setup);
  testing::Random random(8);
  const Pose pose = random_pose(random);
  link_.pose(pose);
  EXPECT_EQ(heard<Odometry>().at(0).frame_id, 1);
  EXPECT_EQ(frames_.at(0).system, 42);
  setup.messages = LinkMessages::kVision;
  configure(setup);
  frames_.clear();
  link_.pose(pose);
  ASSERT_EQ(frames_.size(), 2u);
  const VehiclePose vehicle = vehicle_pose(pose, Mat3::Identity());
  const auto place = heard<VisionPositionEstimate>().at(0);
  const auto speed = heard<VisionSpeedEstimate>().at(0);
  const Vec3 angles = roll_pitch_yaw(vehicle.R_LD);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FLOAT_EQ(place.x_m[i], static_cast<float>(vehicle.p_LD(i)));
    EXPECT_FLOAT_EQ(place.roll_pitch_yaw_rad[i], static_cast<float>(angles(i)));
    EXPECT_FLOAT_EQ(speed.v_m_s[i], static_cast<float>(vehicle.v_LD(i)));
  }
  EXPECT_FLOAT_EQ(place.covariance[20], static_cast<float>(vehicle.cov_pose(5, 5)));
  EXPECT_FLOAT_EQ(speed.covariance[5], static_cast<float>(vehicle.cov_v_LD(1, 2)));
}

TEST_F(robot_link, beats_once_a_second_and_says_how_it_is) {
  for (TimeNs now = 0; now < 10 * kSecond; now += 3 * kMilli) link_.poll(now);
  const auto beats = heard<Heartbeat>();
  EXPECT_EQ(beats.size(), 10u);
  EXPECT_EQ(beats[0].system_status, kStateStandby);
  link_.health(HealthState::kLost, "no images, and this is more text than a status text holds");
  link_.poll(20 * kSecond);
  EXPECT_EQ(heard<Heartbeat>().back().system_status, kStateCritical);
  link_.health(HealthState::kTracking, "found");
  const auto texts = heard<StatusText>();
  ASSERT_EQ(texts.size(), 3u);
  EXPECT_EQ(texts[0].severity, kCritical);
  EXPECT_EQ(std::string(texts[0].text, 50) + texts[1].text,
            "PIRVS lost: no images, and this is more text than a status text holds");
  EXPECT_EQ(texts[0].id, texts[1].id);
  EXPECT_NE(texts[0].id, 0);
  EXPECT_EQ(texts[1].chunk_seq, 1);
  EXPECT_STREQ(texts[2].text, "PIRVS tracking: found");
  EXPECT_EQ(texts[2].id, 0);
}

TEST_F(robot_link, tells_the_time_to_whoever_asks) {
  Timesync question;
  question.ts1_ns = 123;
  say(77 * kMilli, question, 5, 6);
  const auto answers = heard<Timesync>();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].tc1_ns, 77 * kMilli);
  EXPECT_EQ(answers[0].ts1_ns, 123);
  EXPECT_EQ(answers[0].target_system, 5);
  EXPECT_EQ(answers[0].target_component, 6);
  question.target_system = 1;
  question.target_component = 1;
  say(78 * kMilli, question);
  EXPECT_EQ(heard<Timesync>().size(), 1u) << "somebody else was asked";
  Timesync answer = answers[0];
  say(79 * kMilli, answer);
  EXPECT_EQ(heard<Timesync>().size(), 1u) << "an answer has no answer";
}

TEST_F(robot_link, what_does_not_fit_the_wire_is_counted) {
  wire_full_ = true;
  link_.poll(0);
  EXPECT_EQ(link_.counters().dropped, 1u);
  EXPECT_EQ(link_.counters().sent, 0u);
}

// ---- commands ----------------------------------------------------------------------------------

TEST_F(robot_link, a_reset_is_acknowledged_when_it_is_done) {
  say(0, ask(kCommandReset), 255, 190);
  ASSERT_EQ(commands_.size(), 1u);
  EXPECT_EQ(commands_[0].kind, CommandKind::kReset);
  EXPECT_TRUE(heard<CommandAck>().empty());
  say(0, ask(kCommandReset), 255, 190);
  ASSERT_EQ(commands_.size(), 1u) << "asked again, for want of an answer";
  EXPECT_EQ(heard<CommandAck>().at(0).result, kInProgress);
  link_.answer({0, CommandKind::kReset, Status::kOk});
  const CommandAck ack = heard<CommandAck>().at(1);
  EXPECT_EQ(ack.command, kCommandReset);
  EXPECT_EQ(ack.result, kAccepted);
  EXPECT_EQ(ack.target_system, 255);
  EXPECT_EQ(ack.target_component, 190);
  link_.answer({0, CommandKind::kReset, Status::kOk});
  EXPECT_EQ(heard<CommandAck>().size(), 2u) << "told once";
}

TEST_F(robot_link, commands_that_cannot_be_are_refused_by_name) {
  say(0, ask(400));
  EXPECT_EQ(heard<CommandAck>().at(0).result, kUnsupported);
  say(0, ask(kCommandSetPose));
  EXPECT_EQ(heard<CommandAck>().at(1).result, kTemporarilyRejected) << "no pose yet";
  inbox_full_ = true;
  say(0, ask(kCommandReset));
  EXPECT_EQ(heard<CommandAck>().at(2).result, kTemporarilyRejected);
  inbox_full_ = false;
  CommandLong other = ask(kCommandReset);
  other.target_component = kEverybody;
  say(0, other);
  other.target_component = 1;
  say(0, other);
  EXPECT_TRUE(commands_.empty()) << "not told to us";
  EXPECT_EQ(heard<CommandAck>().size(), 3u);
}

TEST_F(robot_link, set_pose_puts_the_vehicle_where_it_is_told_to_be) {
  testing::Random random(4);
  for (int i = 0; i < 20; ++i) {
    LinkSetup setup;
    setup.mounting_rad = Vec3(0, 0, random.uniform(-3, 3));
    configure(setup);
    commands_.clear();
    Pose pose = random_pose(random);
    pose.state.T_WB.R = so3_exp(Vec3(0, 0, random.uniform(-3, 3)));
    link_.pose(pose);
    CommandLong wanted = ask(kCommandSetPose);
    const float yaw_deg = static_cast<float>(random.uniform(-179, 179));
    for (int k = 0; k < 3; ++k) wanted.param[k] = static_cast<float>(k + 1);
    wanted.param[3] = yaw_deg;
    say(0, wanted);
    ASSERT_EQ(commands_.size(), 1u);
    EXPECT_EQ(commands_[0].kind, CommandKind::kSetPose);
    // What the stack then does: turns W so that the IMU's x axis has that heading.
    pose.state.T_WB.p = commands_[0].p_WB;
    pose.state.T_WB.R = so3_exp(Vec3(0, 0, commands_[0].yaw_rad));
    const VehiclePose vehicle = vehicle_pose(pose, mounting(setup.mounting_rad));
    EXPECT_LT((vehicle.p_LD - Vec3(1, 2, 3)).norm(), 1e-6);
    EXPECT_NEAR(roll_pitch_yaw(vehicle.R_LD).z(), static_cast<double>(yaw_deg) * kPi / 180, 1e-6);
    // Without a heading it keeps its own.
    wanted.param[3] = std::nanf("");
    say(0, wanted, 1, 77);
    ASSERT_EQ(commands_.size(), 2u);
  }
}

TEST_F(robot_link, an_imu_whose_x_axis_points_up_has_no_heading_to_set) {
  Pose pose;
  pose.state.T_WB.R = so3_exp(Vec3(0.1, -1.5, 0));
  link_.pose(pose);
  say(0, ask(kCommandSetPose));
  EXPECT_TRUE(commands_.empty());
  EXPECT_EQ(heard<CommandAck>().at(0).result, kDenied);
}

// ---- the robot's sensors -----------------------------------------------------------------------

GpsRawInt some_fix() {
  GpsRawInt out;
  out.time_usec = 1;
  out.lat_1e7_deg = 473'977'420;
  out.lon_1e7_deg = 85'455'940;
  out.alt_mm = 488'000;
  out.alt_ellipsoid_mm = 535'300;
  out.h_acc_mm = 800;
  out.v_acc_mm = 1'500;
  out.fix_type = 3;
  return out;
}

TEST_F(robot_link, a_fix_of_the_autopilot_goes_to_the_door) {
  say(9 * kSecond, some_fix());
  ASSERT_EQ(arrivals_.size(), 1u);
  EXPECT_EQ(arrivals_[0].kind, ArrivalKind::kGnss);
  const GnssFix& fix = arrivals_[0].gnss;
  EXPECT_EQ(fix.t, 9 * kSecond) << "no clock is known: when it came";
  EXPECT_DOUBLE_EQ(fix.latitude_deg, 47.397742);
  EXPECT_DOUBLE_EQ(fix.longitude_deg, 8.545594);
  EXPECT_DOUBLE_EQ(fix.height_m, 535.3);
  EXPECT_DOUBLE_EQ(fix.sigma_horizontal_m, 0.8);
  EXPECT_EQ(fix.type, GnssFixType::k3d);
  EXPECT_FALSE(fix.has_velocity);
}

TEST_F(robot_link, a_fix_has_the_time_of_its_stamp_once_the_clocks_are_known) {
  Heartbeat autopilot;
  autopilot.autopilot = 12;
  say(0, autopilot);
  constexpr TimeNs kOffset = 1'000 * kSecond;  // theirs is so much later
  for (TimeNs now = kSecond; now < 10 * kSecond; now += kSecond) {
    frames_.clear();
    link_.poll(now);
    Timesync answer = heard<Timesync>().at(0);
    EXPECT_EQ(answer.tc1_ns, 0);
    const TimeNs trip = now == 5 * kSecond ? 2 * kMilli : 30 * kMilli;
    answer.target_component = kEverybody;
    // Slow ways back: a quarter of the trip is wrong.
    answer.tc1_ns = answer.ts1_ns + kOffset + trip / 4;
    say(now + trip, answer);
    say(now + trip, answer);  // twice on its way
  }
  GpsRawInt message = some_fix();
  message.time_usec = static_cast<uint64_t>((20 * kSecond - 150 * kMilli + kOffset) / 1000);
  say(20 * kSecond, message);
  EXPECT_NEAR(static_cast<double>(arrivals_.at(0).gnss.t - 20 * kSecond + 150 * kMilli), 0,
              0.6 * kMilli);
  message.time_usec += 10'000'000;  // from the future
  say(21 * kSecond, message);
  EXPECT_EQ(arrivals_.at(1).gnss.t, 21 * kSecond);
}

TEST_F(robot_link, fixes_that_say_nothing_are_refused) {
  GpsRawInt message = some_fix();
  message.fix_type = 1;
  say(1 * kSecond, message);
  EXPECT_EQ(link_.counters().sensors_refused, 0u) << "no fix is no fault";
  message = some_fix();
  message.h_acc_mm = 0;
  message.eph = UINT16_MAX;
  say(2 * kSecond, message);
  message = some_fix();
  message.lat_1e7_deg = 900'000'001;
  say(3 * kSecond, message);
  GpsInput input;
  input.fix_type = 3;
  input.ignore_flags = GpsInput::kNoSigmas;
  say(4 * kSecond, input);
  EXPECT_TRUE(arrivals_.empty());
  EXPECT_EQ(link_.counters().sensors_refused, 3u);
  message = some_fix();
  message.h_acc_mm = 0;
  message.eph = 120;
  say(5 * kSecond, message);
  EXPECT_DOUBLE_EQ(arrivals_.at(0).gnss.sigma_horizontal_m, 3) << "from its dilution";
  input.ignore_flags = 0;
  input.alt_m = 10;
  input.horiz_accuracy_m = input.vert_accuracy_m = 0.02f;
  input.speed_accuracy_m_s = 0.1f;
  input.v_ned_m_s[2] = -1;
  input.fix_type = 6;
  say(6 * kSecond, input);
  EXPECT_TRUE(arrivals_.at(1).gnss.has_velocity);
  EXPECT_EQ(arrivals_.at(1).gnss.v_ned, Vec3(0, 0, -1));
  EXPECT_EQ(arrivals_.at(1).gnss.type, GnssFixType::kFixed);
  input.horiz_accuracy_m = std::nanf("");
  say(7 * kSecond, input);
  EXPECT_EQ(arrivals_.size(), 2u);
}

TEST_F(robot_link, a_flood_of_fixes_comes_to_a_few) {
  for (int i = 0; i < 10'000; ++i) say(kSecond + i * 10'000, some_fix());  // 0.1 s
  EXPECT_LE(arrivals_.size(), 13u);
  EXPECT_GT(link_.counters().sensors_refused, 9'900u);
}

TEST_F(robot_link, wheel_distances_become_speeds) {
  WheelDistance message;
  message.count = 2;
  for (int i = 0; i < 5; ++i) {
    message.time_usec = 1'000'000 + static_cast<uint64_t>(i) * 100'000;
    message.distance_m[0] = 0.1 * i;
    message.distance_m[1] = -0.2 * i;
    say(3 * kSecond + i * 100 * kMilli, message);
  }
  ASSERT_EQ(arrivals_.size(), 4u) << "the first has none before it";
  const WheelSample& wheel = arrivals_[0].wheel;
  EXPECT_EQ(wheel.kind, WheelKind::kLeftRight);
  EXPECT_NEAR(wheel.value[0], 1, 1e-9);
  EXPECT_NEAR(wheel.value[1], -2, 1e-9);
  EXPECT_EQ(wheel.t, 3 * kSecond + 50 * kMilli) << "the middle";
  message.time_usec = 500'000;  // it has started again
  say(4 * kSecond, message);
  message.count = 1;
  say(5 * kSecond, message);
  message.count = 2;
  message.distance_m[0] = std::nan("");
  say(6 * kSecond, message);
  EXPECT_EQ(arrivals_.size(), 4u);
  EXPECT_EQ(link_.counters().sensors_refused, 2u);
}

}  // namespace
}  // namespace pirvs
