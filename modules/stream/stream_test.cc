#include "modules/stream/stream.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "core/math/so3.h"

namespace pirvs::stream {
namespace {

Pose some_pose() {
  Pose pose;
  pose.state.t = 12'345'678'901'234;
  pose.t_published = pose.state.t + 77;
  pose.t_frame = pose.state.t - 5'000'000;
  pose.state.T_WB.p = Vec3(1.25, -2.5, 1e-9);
  pose.state.T_WB.R = so3_exp(Vec3(0.3, -0.2, 1));
  pose.state.v_WB = Vec3(0.5, 0.25, -1);
  pose.w_B = Vec3(0, 3, -3);
  for (int i = 0; i < 9; ++i) pose.cov(i, i) = 1e-4 * (i + 1);
  pose.cov(1, 4) = pose.cov(4, 1) = 3e-5;
  pose.health = HealthState::kDegraded;
  pose.trust.confidence = 0.5f;
  pose.trust.resets = 7;
  pose.epoch = 3;
  pose.in_map = true;
  return pose;
}

TEST(stream, a_pose_comes_back_as_it_went) {
  uint8_t bytes[kMax];
  const Pose pose = some_pose();
  const size_t size = encode(pose, 42, bytes);
  Header header;
  ASSERT_TRUE(decode(bytes, size, header));
  EXPECT_EQ(header.sequence, 42u);
  PoseMessage out;
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, out));
  EXPECT_EQ(out.t, pose.state.t);
  EXPECT_EQ(out.t_published, pose.t_published);
  EXPECT_EQ(out.t_frame, pose.t_frame);
  EXPECT_EQ(out.p_WB, pose.state.T_WB.p);
  EXPECT_LT((out.q_xyzw - quat_xyzw(pose.state.T_WB.R)).norm(), 1e-6);
  EXPECT_EQ(out.v_WB, pose.state.v_WB);
  EXPECT_LT((out.cov_theta_p - pose.cov.topLeftCorner<6, 6>()).norm(), 1e-9);
  EXPECT_LT((out.cov_v - pose.cov.bottomRightCorner<3, 3>()).norm(), 1e-9);
  EXPECT_EQ(out.health, HealthState::kDegraded);
  EXPECT_EQ(out.resets, 7u);
  EXPECT_EQ(out.epoch, 3);
  EXPECT_TRUE(out.in_map);
  EXPECT_FALSE(out.dead_reckoning);
}

TEST(stream, poses_at_200_hz_cost_less_than_60_kB_a_second) {
  uint8_t bytes[kMax];
  constexpr size_t kIpUdp = 28;
  EXPECT_LT(200 * (encode(some_pose(), 0, bytes) + kIpUdp), 60'000u);
}

TEST(stream, what_is_cut_short_or_no_message_is_refused) {
  uint8_t bytes[kMax];
  const size_t size = encode(some_pose(), 1, bytes);
  Header header;
  for (size_t cut = 0; cut < size; ++cut) EXPECT_FALSE(decode(bytes, cut, header)) << cut;
  uint8_t other[kMax];
  std::memcpy(other, bytes, size);
  other[3] = '2';
  EXPECT_FALSE(decode(other, size, header)) << "another version";
  ASSERT_TRUE(decode(bytes, size, header));
  PointsMessage points;
  EXPECT_FALSE(decode(header, bytes + kHeaderBytes, points)) << "another kind";
  Pose broken = some_pose();
  broken.state.T_WB.p(0) = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(decode(bytes, encode(broken, 1, bytes), header));
  PoseMessage out;
  EXPECT_FALSE(decode(header, bytes + kHeaderBytes, out));
}

TEST(stream, every_other_kind_comes_back) {
  uint8_t bytes[kMax];
  Header header;
  HealthMessage health, health_out;
  health.t = 5;
  health.health = HealthState::kLost;
  health.why.put("no images");
  ASSERT_TRUE(decode(bytes, encode(health, 1, bytes), header));
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, health_out));
  EXPECT_STREQ(health_out.why.c_str(), "no images");
  EXPECT_EQ(health_out.health, HealthState::kLost);

  PointsMessage points, points_out;
  points.t = 6;
  points.count = kPointsMax;
  for (int i = 0; i < kPointsMax; ++i) {
    points.points[i].id = static_cast<uint32_t>(i);
    points.points[i].p_W = Eigen::Vector3f(1, 2, static_cast<float>(i));
  }
  Header two;
  two.kind = Kind::kPoints;
  two.part = 1;
  two.parts = 2;
  const size_t size = encode(points, two, bytes);
  EXPECT_LE(size, kMax);
  ASSERT_TRUE(decode(bytes, size, header));
  EXPECT_EQ(header.part, 1);
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, points_out));
  EXPECT_EQ(points_out.count, kPointsMax);
  EXPECT_EQ(points_out.points[69].p_W.z(), 69);

  ThumbnailMessage image, image_out;
  image.width = 160;
  image.height = 120;
  image.offset = 19'200 - 100;
  image.count = 100;
  std::memset(image.pixels, 9, sizeof image.pixels);
  two.kind = Kind::kThumbnail;
  ASSERT_TRUE(decode(bytes, encode(image, two, bytes), header));
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, image_out));
  EXPECT_EQ(image_out.pixels[99], 9);
  image.offset = 19'200 - 99;
  ASSERT_TRUE(decode(bytes, encode(image, two, bytes), header));
  EXPECT_FALSE(decode(header, bytes + kHeaderBytes, image_out)) << "past the image's end";

  SyncInMessage edge;
  const Pose pose = some_pose();
  ASSERT_TRUE(decode(bytes, encode(77, true, &pose, 3, bytes), header));
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, edge));
  EXPECT_TRUE(edge.level && edge.has_pose);
  EXPECT_EQ(edge.pose.t, pose.state.t);

  PpsMessage pps, pps_out;
  const size_t pps_size = encode(PpsMessage{88, -12'345.5, 250, 40, 2}, 3, bytes);
  ASSERT_TRUE(decode(bytes, pps_size, header));
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, pps_out));
  EXPECT_EQ(pps_out.t, 88);
  EXPECT_EQ(pps_out.rate_ppb, -12'345.5);
  EXPECT_EQ(pps_out.noise_ns, 250);
  EXPECT_EQ(pps_out.pulses, 40u);
  EXPECT_EQ(pps_out.odd, 2u);
  pps.rate_ppb = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(decode(bytes, encode(pps, 3, bytes), header));
  EXPECT_FALSE(decode(header, bytes + kHeaderBytes, pps_out));

  SubscribeMessage subscribe;
  ASSERT_TRUE(decode(bytes, encode({bit(Kind::kPose), 5}, bytes), header));
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, subscribe));
  EXPECT_EQ(subscribe.kinds, 2u);
}

TEST(stream, a_pose_on_the_earth_and_a_sample_come_back) {
  FusedPose pose, out;
  pose.t = 12'345'678'901'234;
  pose.T_EB = {so3_exp(Vec3(0.3, -0.2, 1)), Vec3(100.25, -2.5, 1e-9)};
  pose.v_EB = Vec3(0.5, 0.25, -1);
  for (int i = 0; i < 9; ++i) pose.cov(i, i) = 1e-4 * (i + 1);
  pose.cov(1, 4) = pose.cov(4, 1) = 3e-5;
  pose.place = {0.827, 0.149, 488.5};
  pose.health = FusionHealth::kSlamOnly;
  pose.sources = kFromSlam;
  pose.has_heading = true;
  pose.confidence = 0.5f;
  pose.resets = 3;
  uint8_t bytes[kMax];
  Header header;
  const size_t size = encode(pose, 7, bytes);
  ASSERT_TRUE(decode(bytes, size, header));
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, out));
  EXPECT_EQ(out.t, pose.t);
  EXPECT_EQ(out.T_EB.p, pose.T_EB.p);
  EXPECT_LT((out.T_EB.R - pose.T_EB.R).norm(), 1e-14);
  EXPECT_EQ(out.v_EB, pose.v_EB);
  EXPECT_LT((out.cov - pose.cov).norm(), 1e-9);
  EXPECT_EQ(out.place.latitude_rad, pose.place.latitude_rad);
  EXPECT_EQ(out.place.height_m, pose.place.height_m);
  EXPECT_EQ(out.health, FusionHealth::kSlamOnly);
  EXPECT_EQ(out.sources, kFromSlam);
  EXPECT_TRUE(out.has_heading);
  EXPECT_EQ(out.confidence, 0.5f);
  EXPECT_EQ(out.resets, 3u);
  bytes[size - 3] = 99;
  EXPECT_FALSE(decode(header, bytes + kHeaderBytes, out)) << "no such health";

  const ImuSample sample = {77, Vec3(1, 2, 3), Vec3(1.0 / 3, -9.8, 1e-9)};
  ImuSample sample_out;
  ASSERT_TRUE(decode(bytes, encode(sample, 8, bytes), header));
  EXPECT_FALSE(decode(header, bytes + kHeaderBytes, out)) << "another kind";
  ASSERT_TRUE(decode(header, bytes + kHeaderBytes, sample_out));
  EXPECT_EQ(sample_out.t, 77);
  EXPECT_EQ(sample_out.w_B, sample.w_B);
  EXPECT_EQ(sample_out.f_B, sample.f_B);
}

}  // namespace
}  // namespace pirvs::stream
