#include "tools/calib/tag_detector.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "core/math/so3.h"
#include "modules/testing.h"
#include "tools/calib/board_camera.h"
#include "tools/calib/board_drawing.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

struct Errors {
  size_t corners = 0;
  double rms_px = 0, worst_px = 0;
  Vec2 mean_px = Vec2::Zero();
};

Errors errors_of(const std::vector<Corner>& corners, const Camera& camera, const Target& target,
                 const SE3& T_CT) {
  Errors out;
  for (const Corner& corner : corners) {
    Vec2 uv;
    EXPECT_TRUE(camera.project(T_CT * target.p_T(corner.id), uv));
    const double error = (corner.uv - uv).norm();
    out.rms_px += error * error;
    out.worst_px = std::max(out.worst_px, error);
    out.mean_px += corner.uv - uv;
    ++out.corners;
  }
  out.rms_px = std::sqrt(out.rms_px / double(out.corners));
  out.mean_px /= double(out.corners);
  return out;
}

Target small_board() {
  Target out;
  out.columns = out.rows = 4;
  return out;
}

// Facing the camera, turned by theta, its middle at p_C.
SE3 pose(const Target& target, const Vec3& theta, const Vec3& p_C) {
  SE3 out;
  out.R << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  out.R = so3_exp(theta) * out.R;
  out.p = p_C - out.R * target.middle_T();
  return out;
}

TEST(tag_detector, finds_corners_through_a_fisheye_to_a_fraction_of_a_pixel) {
  const Target target = small_board();
  const Camera camera = testing::lens(CameraModel::kKannalaBrandt);
  const BoardCamera board(target, camera);
  const SE3 T_CT = pose(target, Vec3(0.25, -0.3, 0.5), Vec3(0.12, -0.05, 0.45));
  TagDetector detector(target);
  TagDetector::Dropped dropped;
  const auto corners = detector.find(board.draw({T_CT}, {}, 1), dropped);
  const Errors e = errors_of(corners, camera, target, T_CT);
  std::printf("%zu corners, rms %.3f px, worst %.3f, mean %.3f %.3f\n", e.corners, e.rms_px,
              e.worst_px, e.mean_px.x(), e.mean_px.y());
  EXPECT_GE(e.corners, 56u);
  EXPECT_LT(e.rms_px, 0.1);
  EXPECT_LT(e.worst_px, 0.4);
  EXPECT_LT(e.mean_px.norm(), 0.03);
  EXPECT_EQ(dropped.unknown + dropped.doubled + dropped.unsettled, 0u);
}

TEST(tag_detector, holds_up_in_blur_and_darkness) {
  const Target target = small_board();
  const Camera camera = testing::lens(CameraModel::kKannalaBrandt);
  const BoardCamera board(target, camera);
  const SE3 T_CT = pose(target, Vec3(-0.3, 0.3, -1.2), Vec3(0.2, 0.2, 0.4));
  BoardLight dusk;
  dusk.white = 40, dusk.black = 10, dusk.blur_px = 1, dusk.noise = 1;
  TagDetector detector(target);
  TagDetector::Dropped dropped;
  const auto corners = detector.find(board.draw({T_CT}, dusk, 2), dropped);
  const Errors e = errors_of(corners, camera, target, T_CT);
  std::printf("%zu corners, rms %.3f px, worst %.3f\n", e.corners, e.rms_px, e.worst_px);
  EXPECT_GE(e.corners, 32u);
  EXPECT_LT(e.rms_px, 0.2);
}

TEST(tag_detector, takes_what_it_sees_of_a_board_that_the_rim_cuts) {
  const Target target = small_board();
  const Camera camera = testing::lens(CameraModel::kPinholeRadtan);
  const BoardCamera board(target, camera);
  const SE3 T_CT = pose(target, Vec3(0.1, 0.1, 0.2), Vec3(0.32, 0.05, 0.45));
  TagDetector detector(target);
  TagDetector::Dropped dropped;
  const auto corners = detector.find(board.draw({T_CT}, {}, 4), dropped);
  const Errors e = errors_of(corners, camera, target, T_CT);
  EXPECT_GE(e.corners, 20u);
  EXPECT_LT(e.corners, 64u);
  EXPECT_EQ(e.corners % 4, 0u);
  EXPECT_LT(e.rms_px, 0.2);
}

TEST(tag_detector, drops_tags_that_are_there_twice_or_not_on_the_board) {
  const Target target = small_board();
  const Camera camera = testing::lens(CameraModel::kKannalaBrandt);
  const BoardCamera board(target, camera);
  const cv::Mat left = board.draw({pose(target, Vec3(0, 0, 0.1), Vec3(-0.3, 0, 0.6))}, {}, 3);
  cv::Mat both = left.clone();
  const int half = camera.width / 2;
  left(cv::Rect(0, 0, half, left.rows)).copyTo(both(cv::Rect(half, 0, half, left.rows)));
  TagDetector detector(target);
  TagDetector::Dropped dropped;
  EXPECT_LT(detector.find(both, dropped).size(), 17u);
  EXPECT_GT(dropped.doubled, 9u);

  Target few = target;  // the same tags, of which the board is said to have half
  few.rows = 2;
  TagDetector other(few);
  dropped = {};
  (void)other.find(left, dropped);
  EXPECT_GT(dropped.unknown, 2u);
}

TEST(board_drawing, pdf_has_its_size_and_refuses_paper_that_is_too_small) {
  const Target target = small_board();
  const std::string path = ::testing::TempDir() + "/board.pdf";
  write_pdf(target, {}, path);
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  // 4 pitches of 114.4 mm, a gap of 26.4 mm and margins of 5 mm: 494 mm wide.
  EXPECT_NE(text.str().find("/MediaBox [0 0 1400.31"), std::string::npos);
  EXPECT_NE(text.str().find("%%EOF"), std::string::npos);
  EXPECT_THROW(write_pdf(target, {297, 420}, path), InputError);
}

}  // namespace
}  // namespace pirvs::tools
