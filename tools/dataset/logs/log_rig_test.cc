#include "tools/dataset/logs/log_rig.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

// A message as ROS 1 or CDR has it, little endian.
class Writer {
 public:
  explicit Writer(bool cdr) : cdr_(cdr) {
    if (cdr) bytes_ = {0, 1, 0, 0};
  }
  template <class T>
  Writer& put(T value) {
    while (cdr_ && (bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    const auto* const raw = reinterpret_cast<const uint8_t*>(&value);
    bytes_.insert(bytes_.end(), raw, raw + sizeof value);
    return *this;
  }
  Writer& text(const std::string& text) {
    put(uint32_t(text.size() + (cdr_ ? 1 : 0)));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    if (cdr_) bytes_.push_back(0);
    return *this;
  }
  Writer& header(const std::string& frame) {
    if (!cdr_) put(uint32_t{7});
    return put(uint32_t{5}).put(uint32_t{6}).text(frame);
  }
  template <class Numbers>
  Writer& all(const Numbers& numbers) {
    for (const double number : numbers) put(number);
    return *this;
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  bool cdr_;
  std::vector<uint8_t> bytes_;
};

Bytes view(const std::vector<uint8_t>& bytes) { return {bytes.data(), bytes.size()}; }

std::vector<uint8_t> info_message(bool cdr) {
  Writer out(cdr);
  out.header("left").put(uint32_t{480}).put(uint32_t{640}).text("plumb_bob").put(uint32_t{5});
  out.all(std::initializer_list<double>{0.1, 0.2, 0.003, 0.004, 0.5});
  out.all(std::initializer_list<double>{400, 0, 320, 0, 401, 240, 0, 0, 1});
  out.all(std::initializer_list<double>{0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, 1});
  out.all(std::initializer_list<double>{390, 0, 321, -39, 0, 391, 241, 0, 0, 0, 1, 0});
  for (const uint32_t value : {2u, 4u, 10u, 20u, 200u, 300u}) out.put(value);
  return out.put(uint8_t{1}).bytes();
}

TEST(ros_message, camera_info_of_both_encodings) {
  for (const bool cdr : {false, true}) {
    const auto bytes = info_message(cdr);
    CameraInfo info;
    ASSERT_TRUE(decode_camera_info(view(bytes), cdr, info));
    EXPECT_EQ(info.frame_id, "left");
    EXPECT_EQ(info.distortion_model, "plumb_bob");
    EXPECT_EQ(info.width, 640u);
    EXPECT_EQ(info.height, 480u);
    EXPECT_EQ(info.D, (std::vector<double>{0.1, 0.2, 0.003, 0.004, 0.5}));
    EXPECT_EQ(info.K(1, 1), 401);
    EXPECT_EQ(info.R(1, 0), -0.6);
    EXPECT_EQ(info.P(0, 3), -39);
    EXPECT_EQ(info.P(1, 2), 241);
    EXPECT_EQ(info.binning_y, 4u);
    EXPECT_EQ(info.roi_x, 10u);
    EXPECT_EQ(info.roi_height, 200u);
    EXPECT_EQ(info.roi_width, 300u);
    // Cut off anywhere before its last byte, which does not count here.
    for (size_t size = 0; size + 1 < bytes.size(); ++size) {
      EXPECT_FALSE(decode_camera_info({bytes.data(), size}, cdr, info)) << size;
    }
  }
}

TEST(ros_message, transforms_of_both_encodings) {
  for (const bool cdr : {false, true}) {
    Writer out(cdr);
    out.put(uint32_t{2});
    for (const char* child : {"left", "imu"}) {
      out.header("base").text(child).all(std::initializer_list<double>{1, 2, 3});
      out.all(std::initializer_list<double>{-0.5, 0.5, -0.5, 0.5});
    }
    std::vector<RosTransform> links;
    ASSERT_TRUE(decode_transforms(view(out.bytes()), cdr, links));
    ASSERT_EQ(links.size(), 2u);
    EXPECT_EQ(links[1].parent, "base");
    EXPECT_EQ(links[1].child, "imu");
    EXPECT_EQ(links[1].T.p, Vec3(1, 2, 3));
    EXPECT_LT((links[1].T.R * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-12);
    EXPECT_LT((links[1].T.R * Vec3::UnitX() + Vec3::UnitY()).norm(), 1e-12);
    EXPECT_FALSE(decode_transforms({out.bytes().data(), out.bytes().size() - 1}, cdr, links));
  }
}

// ---- the rig -----------------------------------------------------------------------------------
class log_rig : public testing::Test {
 protected:
  log_rig() {
    for (LogCamera& camera : cameras) {
      camera.info.width = 640;
      camera.info.height = 480;
      camera.info.distortion_model = "plumb_bob";
      camera.info.D = {0.1, 0.2, 0.003, 0.004, 0};
      camera.info.K << 400, 0, 320, 0, 401, 240, 0, 0, 1;
      camera.info.R.setIdentity();
      camera.info.P << 390, 0, 321, 0, 0, 391, 241, 0, 0, 0, 1, 0;
    }
    cameras[1].info.P(0, 3) = -39;  // 0.1 m to the right
    // The left camera looks along x of the IMU, its x is -y, its y is -z.
    RosTransform imu{"base", "imu", {}}, left{"mount", "left", {}}, mount{"base", "mount", {}};
    imu.T.p = Vec3(1, 2, 3);
    mount.T.p = Vec3(1.02, 0, 0);
    left.T.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    left.T.p = Vec3(0, 2.05, 2.97);
    transforms = {left, imu, mount};
  }
  RigFile read() const { return rig_of_log("LOG", cameras, "imu", transforms); }
  SE3 right_in_left() const {
    const RigFile rig = read();
    return rig.cameras.at(0).T_BC.inverse() * rig.cameras.at(1).T_BC;
  }
  std::string refusal() const {
    try {
      read();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  std::vector<LogCamera> cameras = {{"/left/image_raw", "left", "/left/camera_info", {}},
                                    {"/right/image_raw", "right", "/right/camera_info", {}}};
  std::vector<RosTransform> transforms;
};

TEST_F(log_rig, has_lenses_poses_and_the_baseline) {
  const RigFile rig = read();
  ASSERT_EQ(rig.cameras.size(), 2u);
  const RigCamera& left = rig.cameras[0];
  EXPECT_EQ(left.topic, "/left/image_raw");
  EXPECT_EQ(left.lens.fx, 400);
  EXPECT_EQ(left.lens.cy, 240);
  EXPECT_EQ(left.lens.distortion, Distortion::kRadtan);
  EXPECT_EQ(left.lens.d[3], 0.004);
  EXPECT_LT((left.T_BC.p - Vec3(0.02, 0.05, -0.03)).norm(), 1e-12);
  EXPECT_LT((left.T_BC.R * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((right_in_left().p - Vec3(0.1, 0, 0)).norm(), 1e-12);
}

// A point of the world, 2 m before the left camera's rectified image and 0.3 m to its right, is at
// the same height of both rectified images, a disparity of 390 * 0.1 / 2 apart.
TEST_F(log_rig, rotations_of_rectification_are_of_the_raw_cameras) {
  cameras[0].info.R << 0.8, 0, 0.6, 0, 1, 0, -0.6, 0, 0.8;
  cameras[1].info.R << 0.8, 0, -0.6, 0, 1, 0, 0.6, 0, 0.8;
  const Vec3 p_rect(0.3, 0.2, 2);
  const Vec3 p_left = cameras[0].info.R.transpose() * p_rect;
  const Vec3 p_right = right_in_left().inverse() * p_left;
  const Vec3 there = cameras[1].info.R * p_right;
  EXPECT_LT((there - Vec3(0.2, 0.2, 2)).norm(), 1e-12);
  EXPECT_NEAR(390 * (p_rect.x() / 2 - there.x() / 2), 19.5, 1e-9);
  // The images of rectified topics are those of rectified cameras.
  const SE3 T_BC_raw = read().cameras[0].T_BC;
  for (LogCamera& camera : cameras) camera.topic = "/x/image_rect_raw";
  const RigFile rig = read();
  EXPECT_LT((right_in_left().R - Mat3::Identity()).norm(), 1e-12);
  EXPECT_LT((right_in_left().p - Vec3(0.1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((rig.cameras[0].T_BC * p_rect - T_BC_raw * p_left).norm(), 1e-12);
  EXPECT_EQ(rig.cameras[0].lens.fx, 390);
  EXPECT_EQ(rig.cameras[0].lens.cx, 321);
  EXPECT_EQ(rig.cameras[0].lens.distortion, Distortion::kNone);
}

TEST_F(log_rig, has_three_models) {
  CameraInfo& info = cameras[0].info;
  info.distortion_model = "rational_polynomial";
  info.D = {1, 2, 3, 4, 5, 6, 7, 8};
  EXPECT_EQ(read().cameras[0].lens.d[7], 8);
  info.distortion_model = "equidistant";
  info.D = {0.1, 0.2, 0.3, 0.4};
  EXPECT_EQ(read().cameras[0].lens.distortion, Distortion::kEquidistant);
  info.distortion_model = "";
  info.D = {};
  EXPECT_EQ(read().cameras[0].lens.distortion, Distortion::kNone);
}

TEST_F(log_rig, takes_binning_and_regions) {
  CameraInfo& info = cameras[0].info;
  info.binning_x = info.binning_y = 2;
  info.roi_x = 20, info.roi_y = 40, info.roi_width = 600, info.roi_height = 400;
  const Lens lens = read().cameras[0].lens;
  EXPECT_EQ(lens.width, 300);
  EXPECT_EQ(lens.height, 200);
  EXPECT_EQ(lens.fx, 200);
  EXPECT_EQ(lens.cx, 150);
  EXPECT_EQ(lens.cy, 100);
}

// Without a baseline in P, as of two cameras that were calibrated alone, transforms have it.
TEST_F(log_rig, transforms_have_the_right_camera_where_its_info_has_not) {
  cameras[1].info.P(0, 3) = 0;
  EXPECT_NE(refusal().find("no baseline"), std::string::npos) << refusal();
  RosTransform right{"left", "right", {}};
  right.T.p = Vec3(0.12, 0, 0);
  transforms.push_back(right);
  EXPECT_LT((right_in_left().p - Vec3(0.12, 0, 0)).norm(), 1e-12);
}

TEST_F(log_rig, what_is_missing_is_told) {
  const auto expect_told = [&](const char* what) {
    EXPECT_NE(refusal().find(what), std::string::npos) << refusal();
    EXPECT_EQ(refusal().find('\n'), std::string::npos);
  };
  const auto good = cameras;
  cameras[0].info.K.setZero();
  expect_told("not calibrated");
  cameras = good;
  cameras[1].info.distortion_model = "thin_prism";
  expect_told("unknown model 'thin_prism'");
  cameras = good;
  cameras[0].info.D = {1, 2};
  expect_told("needs 0, 4, 5, 8");
  cameras = good;
  cameras[1].info.width = 0;
  expect_told("needs width and height");
  cameras = good;
  cameras[0].info.R(0, 0) = 3;
  expect_told("not a rotation");
  cameras = good;
  transforms.pop_back();
  expect_told("no transform from 'left' to 'imu'");
}

TEST(info_topic, stands_beside_the_images) {
  EXPECT_EQ(info_topic_of("/cam0/image_raw"), "/cam0/camera_info");
  EXPECT_EQ(info_topic_of("/cam0/image_raw/compressed"), "/cam0/camera_info");
  EXPECT_EQ(info_topic_of("/camera/infra1/image_rect_raw"), "/camera/infra1/camera_info");
}

}  // namespace
}  // namespace pirvs::tools
