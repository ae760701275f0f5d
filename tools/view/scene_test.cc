#include "tools/view/scene.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <limits>

#include "tools/dataset/input_error.h"
#include "tools/view/page.h"

namespace pirvs::tools {
namespace {

using nlohmann::json;

// As docs/view.md says.
json header_of(const ViewMessage& message) {
  if (!message.binary) return json::parse(*message.bytes);
  uint32_t size = 0;
  std::memcpy(&size, message.bytes->data(), sizeof size);
  EXPECT_EQ(size % 4, 0U);
  return json::parse(message.bytes->substr(sizeof size, size));
}

std::vector<float> array_of(const ViewMessage& message) {
  uint32_t size = 0;
  std::memcpy(&size, message.bytes->data(), sizeof size);
  const std::string bytes = message.bytes->substr(sizeof size + size);
  std::vector<float> out(bytes.size() / sizeof(float));
  std::memcpy(out.data(), bytes.data(), bytes.size());
  return out;
}

const ViewMessage* find(const std::vector<ViewMessage>& messages, const std::string& type) {
  for (const ViewMessage& message : messages) {
    if (header_of(message)["type"] == type) return &message;
  }
  return nullptr;
}

ViewPose pose_at(double x, uint32_t resets = 0) {
  static TimeNs t = 0;
  ViewPose out;
  out.t = out.t_frame = t += 5'000'000;
  out.t_published = out.t + 2'000'000;
  out.p_WB = Vec3(x, 0, 0);
  out.resets = resets;
  out.confidence = 0.5F;
  return out;
}

TEST(view_scene, news_are_told_once_and_all_of_it_to_who_comes) {
  ViewScene scene;
  scene.begin({{"kind", "replay"}});
  scene.pose(pose_at(0));
  scene.pose(pose_at(1));
  const auto news = scene.news(1);
  ASSERT_NE(find(news, "path"), nullptr);
  EXPECT_EQ(array_of(*find(news, "path")).size(), 10U);
  EXPECT_EQ(header_of(*find(news, "path"))["all"], true);
  EXPECT_EQ(header_of(*find(news, "state"))["p"][0], 1.0);
  EXPECT_TRUE(scene.news(2).empty());
  scene.pose(pose_at(2));
  const auto more = scene.news(3);
  EXPECT_EQ(array_of(*find(more, "path")).size(), 5U);
  EXPECT_EQ(header_of(*find(more, "path"))["all"], false);
  const auto all = scene.all();
  EXPECT_EQ(header_of(all.front())["type"], "hello");
  EXPECT_EQ(array_of(*find(all, "path")).size(), 15U);
}

TEST(view_scene, points_are_old_after_a_jump_until_they_are_seen_again) {
  ViewScene scene;
  scene.pose(pose_at(0));
  scene.points({{7, {1, 2, 3}, 0.1F}, {8, {4, 5, 6}, 0.1F}});
  (void)scene.news(1);
  scene.pose(pose_at(0, 1));
  ASSERT_NE(find(scene.news(2), "jump"), nullptr);
  scene.points({{8, {4, 5, 7}, 0.1F}});
  (void)scene.news(3);
  const std::vector<float> rows = array_of(*find(scene.all(), "points"));
  ASSERT_EQ(rows.size(), 12U);
  for (int i = 0; i < 2; ++i) {
    uint32_t id = 0, old = 0;
    std::memcpy(&id, &rows[size_t(6 * i)], sizeof id);
    std::memcpy(&old, &rows[size_t(6 * i + 5)], sizeof old);
    EXPECT_EQ(old, id == 7 ? 1U : 0U);
  }
}

std::vector<std::string> events_of(const std::vector<ViewMessage>& messages) {
  std::vector<std::string> out;
  for (const ViewMessage& message : messages) {
    const json header = header_of(message);
    if (header["type"] == "event") out.push_back(header["what"]);
  }
  return out;
}

// A device does not say how far it jumped: what its speed does not explain.
TEST(view_scene, jumps_epochs_and_the_map_are_events) {
  ViewScene scene;
  ViewPose pose = pose_at(0);
  scene.pose(pose);
  EXPECT_EQ(events_of(scene.news(1)).size(), 0U);
  pose = pose_at(2.005, 1);
  pose.v_WB = Vec3(1, 0, 0);
  pose.epoch = 1;
  pose.in_map = true;
  ViewPose before = pose;
  before.t -= 5'000'000;
  before.p_WB.x() = 0;
  before.resets = before.epoch = 0;
  before.in_map = false;
  scene.pose(before);
  scene.pose(pose);
  const auto news = scene.news(2);
  EXPECT_EQ(events_of(news),
            (std::vector<std::string>{"the pose jumped by 2.000 m: reset 1", "epoch 0 to 1",
                                      "localised in the loaded map"}));
  EXPECT_EQ(header_of(*find(news, "state"))["in_map"], true);
  EXPECT_EQ(events_of(scene.all()).size(), 3U);
  pose = pose_at(2.1, 2);
  pose.jump_m = 0.5F;
  pose.epoch = 1;
  pose.in_map = true;
  scene.pose(pose);
  EXPECT_EQ(events_of(scene.news(3)),
            (std::vector<std::string>{"the pose jumped by 0.500 m: reset 2"}));
}

TEST(view_scene, another_source_keeps_the_earlier_map) {
  ViewScene scene;
  scene.earlier_map({{1, 2, 3}}, true);
  EXPECT_EQ(header_of(*find(scene.news(1), "earlier_map"))["loaded"], true);
  scene.begin({{"kind", "replay"}});
  const auto news = scene.news(2);
  EXPECT_EQ(header_of(news.front())["type"], "hello");
  ASSERT_NE(find(news, "earlier_map"), nullptr);
  EXPECT_EQ(array_of(*find(news, "earlier_map")).size(), 3U);
  scene.earlier_map({}, true);
  EXPECT_EQ(header_of(*find(scene.news(3), "earlier_map"))["count"], 0);
  EXPECT_EQ(find(scene.all(), "earlier_map"), nullptr);
}

TEST(view_scene, what_lasts_is_bounded) {
  ViewScene scene;
  for (size_t i = 0; i < 3 * ViewScene::kPathMax; ++i) scene.pose(pose_at(double(i)));
  std::vector<ViewPoint> points;
  for (size_t i = 0; i < ViewScene::kPointsMax + 10; ++i) {
    points.push_back({uint32_t(i), Eigen::Vector3f::Zero(), 0});
  }
  scene.points(points);
  for (size_t i = 0; i < 2 * ViewScene::kEventsMax; ++i) {
    scene.health(TimeNs(i), HealthState::kLost, "again");
  }
  const auto all = scene.all();
  const size_t places = header_of(*find(all, "path"))["count"];
  EXPECT_LE(places, ViewScene::kPathMax);
  EXPECT_GT(places, ViewScene::kPathMax / 4);
  EXPECT_EQ(header_of(*find(all, "points"))["count"], ViewScene::kPointsMax);
  size_t events = 0;
  for (const ViewMessage& message : all) events += header_of(message)["type"] == "event" ? 1 : 0;
  EXPECT_EQ(events, ViewScene::kEventsMax);
}

TEST(view_scene, rates_are_of_the_last_second) {
  ViewScene scene;
  constexpr TimeNs kSecond_ns = 1'000'000'000;
  (void)scene.news(kSecond_ns);
  for (int i = 0; i < 100; ++i) scene.pose(pose_at(i));
  EXPECT_EQ(find(scene.news(kSecond_ns + 1), "rates"), nullptr);
  const auto news = scene.news(3 * kSecond_ns);
  ASSERT_NE(find(news, "rates"), nullptr);
  const json rates = header_of(*find(news, "rates"));
  EXPECT_EQ(rates["poses_hz"], 50);
  EXPECT_NEAR(rates["imu_to_pose_ms"]["median"], 2, 1e-3);
}

TEST(view_scene, what_is_no_number_and_no_text_is_said_so) {
  EXPECT_TRUE(view_number(std::numeric_limits<double>::quiet_NaN()).is_null());
  EXPECT_EQ(view_number(1.0 / 3).dump(), "0.333333");
  ViewScene scene;
  scene.health(0, HealthState::kLost, "\xff\"<script>");
  EXPECT_EQ(header_of(*find(scene.news(1), "event"))["what"], "\xEF\xBF\xBD\"<script>");
}

TEST(view_scene, only_a_ply_of_text_is_a_map) {
  const std::string path = ::testing::TempDir() + "/view_map.ply";
  const auto write = [&](const std::string& text) { std::ofstream(path) << text; };
  write("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n1 2 3\n4 5 6 7\n");
  ASSERT_EQ(read_ply(path).size(), 2U);
  EXPECT_EQ(read_ply(path)[1].y(), 5);
  for (const char* const text :
       {"", "ply\nformat binary_little_endian 1.0\nend_header\n", "ply\nformat ascii 1.0\n",
        "ply\nformat ascii 1.0\nelement vertex 1\nend_header\n1 2 x\n"}) {
    write(text);
    EXPECT_THROW((void)read_ply(path), InputError) << text;
  }
}

}  // namespace
}  // namespace pirvs::tools
