#include "modules/map/nodes.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "core/math/so3.h"

namespace pirvs {
namespace {

class Nodes : public testing::Test {
 protected:
  KeyframeId add(const Vec3& p_WB, uint16_t epoch = 1) {
    const KeyframeId id = map_->keyframes.acquire().value();
    Keyframe& keyframe = *map_->keyframes.find(id);
    keyframe.state.T_WB = {so3_exp(Vec3(0, 0, p_WB.x())), p_WB};
    keyframe.epoch = epoch;
    return id;
  }
  Vec3 place(const char* name) const { return node_pose(*map_, name).value().p; }

  std::unique_ptr<Map> map_ = std::make_unique<Map>();
};

TEST_F(Nodes, AreFoundByNameUntilTheyAreRemoved) {
  add({0, 0, 0});
  const SE3 dock{so3_exp(Vec3(0.1, 0.2, 0.3)), Vec3(1, 2, 3)};
  ASSERT_EQ(set_node(*map_, "dock", dock, 1), Status::kOk);
  EXPECT_LT((place("dock") - dock.p).norm(), 1e-12);
  EXPECT_LT((node_pose(*map_, "dock").value().R - dock.R).norm(), 1e-12);
  ASSERT_EQ(set_node(*map_, "dock", {Mat3::Identity(), Vec3(4, 5, 6)}, 1), Status::kOk);
  EXPECT_EQ(map_->nodes.size(), 1u) << "in place of the old one";
  EXPECT_LT((place("dock") - Vec3(4, 5, 6)).norm(), 1e-12);
  EXPECT_EQ(remove_node(*map_, "dock"), Status::kOk);
  EXPECT_EQ(node_pose(*map_, "dock").status(), Status::kNotFound);
  EXPECT_EQ(remove_node(*map_, "dock"), Status::kNotFound);
}

TEST_F(Nodes, GoAlongWithTheKeyframeNextToThem) {
  add({0, 0, 0});
  const KeyframeId near = add({5, 0, 0});
  ASSERT_EQ(set_node(*map_, "dock", {Mat3::Identity(), Vec3(5.5, 0, 0)}, 1), Status::kOk);
  map_->keyframes.find(near)->state.T_WB.p += Vec3(0, 0, 0.25);
  EXPECT_LT((place("dock") - Vec3(5.5, 0, 0.25)).norm(), 1e-12);
}

TEST_F(Nodes, SurviveTheKeyframeThatTheyAreFixedTo) {
  const KeyframeId far = add({0, 0, 0}), near = add({5, 0, 0}), other = add({5.4, 0, 0}, 2);
  ASSERT_EQ(set_node(*map_, "dock", {Mat3::Identity(), Vec3(5.5, 0, 0)}, 1), Status::kOk);
  carry_nodes(*map_, near);
  ASSERT_TRUE(map_->keyframes.release(near));
  EXPECT_LT((place("dock") - Vec3(5.5, 0, 0)).norm(), 1e-12);
  map_->keyframes.find(other)->state.T_WB.p += Vec3(1, 0, 0);
  EXPECT_LT((place("dock") - Vec3(5.5, 0, 0)).norm(), 1e-12) << "not of its epoch";
  carry_nodes(*map_, far);
  EXPECT_EQ(map_->nodes.size(), 0u) << "nothing of its epoch is left";
}

TEST_F(Nodes, RefuseWhatCannotBe) {
  EXPECT_EQ(set_node(*map_, "dock", SE3{}, 1), Status::kNotFound) << "an empty map";
  add({0, 0, 0});
  EXPECT_EQ(set_node(*map_, "dock", SE3{}, 2), Status::kNotFound) << "of another epoch";
  for (const char* name : {"", "a b", "../x", "a-name-that-is-too-long-for-it"}) {
    EXPECT_EQ(set_node(*map_, name, SE3{}, 1), Status::kBadData) << name;
  }
  EXPECT_EQ(set_node(*map_, "dock", {Mat3::Identity(), Vec3::Constant(std::nan(""))}, 1),
            Status::kBadData);
  for (size_t i = 0; i < kNodesMax; ++i) {
    ASSERT_EQ(set_node(*map_, std::to_string(i).c_str(), SE3{}, 1), Status::kOk);
  }
  EXPECT_EQ(set_node(*map_, "one-more", SE3{}, 1), Status::kFull);
  EXPECT_EQ(set_node(*map_, "7", SE3{}, 1), Status::kOk) << "in place of another";
}

}  // namespace
}  // namespace pirvs
