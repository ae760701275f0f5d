#include "modules/frontend/frontend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "core/kernels/corner/corner.h"
#include "core/kernels/hamming/hamming.h"
#include "modules/frontend/track_table.h"
#include "modules/testing.h"

namespace pirvs {
namespace {

using testing::Texture;

constexpr int kSide = 220;  // margins of 20 px and five bins of 36 px
const Vec3 kDown_C(0, 9.81, 0);

// A plain camera before a texture that slides by.
struct Slide {
  explicit Slide(uint32_t seed = 1, int width = kSide, int height = kSide) : texture(seed) {
    camera.width = width;
    camera.height = height;
    camera.fx = camera.fy = 150;
    camera.cx = (width - 1) / 2.0;
    camera.cy = (height - 1) / 2.0;
    params.tracks_target = 200;
    params.bin_px = 36;
    frontend->configure(camera, params);
  }
  // The point of the scene at (x, y) of the first image is at (x + shift) of this one.
  std::vector<uint8_t> image(const Vec2& shift, double gain = 1, double offset = 0) const {
    std::vector<uint8_t> out;
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const double grey = texture.at((x - shift.x()) / 10, (y - shift.y()) / 10);
        out.push_back(static_cast<uint8_t>(std::lround(gain * grey + offset)));
      }
    }
    return out;
  }
  Status show(const std::vector<uint8_t>& pixels, const Vec3& gravity_C = kDown_C) {
    frontend->predict(Mat3::Identity());
    const ImageView view = {pixels.data(), camera.width, camera.height, camera.width};
    return frontend->process(view, t += 50'000'000, gravity_C);
  }
  const Tracks& tracks() const { return frontend->tracks(); }
  uint32_t lost(TrackLoss loss) const { return frontend->losses()[loss]; }
  const Track* find(TrackId id) const {
    for (const Track& track : tracks()) {
      if (track.id == id) return &track;
    }
    return nullptr;
  }

  Texture texture;
  Camera camera;
  FrontendParams params;
  std::unique_ptr<Frontend> frontend = std::make_unique<Frontend>();
  TimeNs t = 0;
};

TEST(frontend, fills_every_bin_with_a_described_track) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  std::set<int> bins;
  for (const Track& track : s.tracks()) {
    bins.insert((static_cast<int>(track.y) - 20) / 36 * 5 + (static_cast<int>(track.x) - 20) / 36);
    EXPECT_TRUE(track.described);
    EXPECT_EQ(track.age, 0);
    for (const Track& other : s.tracks()) {
      if (other.id == track.id) continue;
      EXPECT_GE(std::hypot(other.x - track.x, other.y - track.y), s.params.track_spacing_px_min);
    }
  }
  EXPECT_GE(bins.size(), 20u) << "of 25; the spacing may leave some empty";
}

// The right half is nearer: it moves one pixel more and covers what was behind its edge.
TEST(frontend, patches_across_the_edge_of_a_near_object_are_dropped) {
  const auto worst = [](float ratio) {
    Slide s(3, 400, 300);
    s.params.lk_residual_ratio_max = ratio;
    s.params.lk_residual_grey_max = 128;
    s.params.lk_return_px_max = 3;
    s.frontend->configure(s.camera, s.params);
    const auto image = [&s](double shift) {
      std::vector<uint8_t> far = s.image(Vec2(shift, 0)),
                           near = s.image(Vec2(100 + 1.5 * shift, 0));
      for (int y = 0; y < 300; ++y) {
        const int edge = 200 + static_cast<int>(1.5 * shift);
        std::copy(near.begin() + y * 400 + edge, near.begin() + (y + 1) * 400,
                  far.begin() + y * 400 + edge);
      }
      return far;
    };
    EXPECT_EQ(s.show(image(0)), Status::kOk);
    std::map<TrackId, Vec2> before;
    for (const Track& track : s.tracks()) before[track.id] = Vec2(track.x, track.y);
    EXPECT_EQ(s.show(image(-2)), Status::kOk);
    int followed = 0;
    double error = 0;
    for (const Track& track : s.tracks()) {
      if (track.age == 0) continue;
      ++followed;
      const Vec2 from = before[track.id];
      const double moved = from.x() < 200 ? -2 : -3;
      error = std::max(error, std::hypot(track.x - from.x() - moved, track.y - from.y()));
    }
    EXPECT_GT(followed, 30);
    return error;
  };
  EXPECT_GT(worst(100), 0.3) << "without the rule";
  EXPECT_LT(worst(2), 0.1);
}

TEST(frontend, any_legal_cell_size_suits_any_image) {
  for (int side = 16; side <= 64; ++side) {
    for (const int width : {16, 40, 41, 55, 100, 512, 752, 848, 1024, 1280}) {
      for (const int height : {16, 48, 480, 800, 1024, 1280}) {
        const DetectionGrid grid = detection_grid(width, height, side);
        const bool room = width > 40 && height > 40;
        ASSERT_EQ(grid.columns > 0 && grid.rows > 0, room);
        ASSERT_LE(grid.columns * grid.rows, kDetectionCellsMax);
        ASSERT_LE(grid.side_px, kCornerSizeMax);
        if (!room) continue;
        ASSERT_LE(grid.columns * grid.side_px, width - 40);
        ASSERT_LE(grid.rows * grid.side_px, height - 40);
        if (width <= 752 && height <= 480 && std::min(width, height) >= 40 + side) {
          ASSERT_EQ(grid.side_px, side) << "as wanted where it fits";
        }
      }
    }
  }
}

TEST(frontend, an_image_that_is_all_margin_has_no_tracks) {
  Slide s;
  s.camera.width = s.camera.height = 40;
  s.frontend->configure(s.camera, s.params);
  const std::vector<uint8_t> grey(40 * 40, 100);
  EXPECT_EQ(s.frontend->process({grey.data(), 40, 40, 40}, 1, kDown_C), Status::kOk);
  EXPECT_EQ(s.tracks().size(), 0u);
}

// Tracks stand in all nine parts of the image and are followed there.
void expect_followed_everywhere(int width, int height, float bin_px) {
  Slide s(1, width, height);
  s.params.bin_px = bin_px;
  s.params.tracks_target = 240;
  s.frontend->configure(s.camera, s.params);
  const Vec2 step(3.3, -1.7);
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  ASSERT_EQ(s.show(s.image(step)), Status::kOk);
  int parts[9] = {};
  for (const Track& track : s.tracks()) {
    if (track.age == 0) continue;
    EXPECT_NEAR(track.x - track.x_last, step.x(), 0.2);
    EXPECT_NEAR(track.y - track.y_last, step.y(), 0.2);
    ++parts[static_cast<int>(track.y) * 3 / height * 3 + static_cast<int>(track.x) * 3 / width];
  }
  for (const int tracks : parts) EXPECT_GE(tracks, 3) << width << " x " << height;
}

TEST(frontend, follows_in_images_of_every_shape) {
  expect_followed_everywhere(480, 752, 36);
  expect_followed_everywhere(512, 512, 36);
  expect_followed_everywhere(1280, 800, 60);
  expect_followed_everywhere(1024, 1280, 64);
}

TEST(frontend, the_largest_image_may_have_the_smallest_bins) {
  expect_followed_everywhere(1024, 1280, kBinMin_px);
}

TEST(frontend, keeps_to_the_number_of_tracks_wanted) {
  Slide s;
  s.params.tracks_target = 12;
  s.frontend->configure(s.camera, s.params);
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  EXPECT_EQ(s.tracks().size(), 12u);
}

TEST(frontend, ids_persist_and_places_are_sub_pixel) {
  Slide s;
  const Vec2 step(3.3, -1.7);
  std::map<TrackId, Vec2> scene;  // where each track's point was in the first image
  std::set<TrackId> ever;
  for (int i = 0; i <= 10; ++i) {
    const Vec2 shift = i * step;
    ASSERT_EQ(s.show(s.image(shift)), Status::kOk);
    for (const Track& track : s.tracks()) {
      const Vec2 at = Vec2(track.x, track.y) - shift;
      if (track.age == 0) {
        EXPECT_TRUE(ever.insert(track.id).second) << "an id is never given twice";
        scene[track.id] = at;
      }
      ASSERT_EQ(scene.count(track.id), 1u);
      EXPECT_LT((at - scene[track.id]).norm(), 0.1 + 0.02 * track.age) << track.age;
      if (track.age > 0) {
        EXPECT_LT((Vec2(track.x - track.x_last, track.y - track.y_last) - step).norm(), 0.1);
      }
    }
  }
  int old = 0;
  for (const Track& track : s.tracks()) old += track.age == 10 ? 1 : 0;
  EXPECT_GE(old, 10) << "33 px of 220 have left, the rest is still followed";
}

TEST(frontend, large_motion_is_bridged_by_the_pyramid) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  const size_t before = s.tracks().size();
  ASSERT_EQ(s.show(s.image(Vec2(9, -7))), Status::kOk);
  size_t followed = 0;
  for (const Track& track : s.tracks()) {
    if (track.age == 0) continue;
    ++followed;
    EXPECT_LT((Vec2(track.x - track.x_last, track.y - track.y_last) - Vec2(9, -7)).norm(), 0.2);
  }
  EXPECT_GE(followed, before * 7 / 10);
}

TEST(frontend, a_good_prediction_bridges_any_motion) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  const std::vector<uint8_t> next = s.image(Vec2(60, 0));
  s.frontend->predict(Mat3::Identity());
  size_t expected = 0, followed = 0;
  for (size_t i = 0; i < s.tracks().size(); ++i) {
    Track& track = s.frontend->track(i);
    track.x_pred = track.x + 59;
    expected += track.x + 60 < kSide - 20 ? 1 : 0;
  }
  ASSERT_EQ(s.frontend->process({next.data(), kSide, kSide, kSide}, 1'000'000'000, kDown_C),
            Status::kOk);
  for (const Track& track : s.tracks()) followed += track.age == 1 ? 1 : 0;
  EXPECT_GE(followed, expected * 9 / 10);
}

TEST(frontend, what_turning_does_not_explain_is_expected_to_go_on) {
  Slide s(2, 400, 300);
  for (int i = 0; i < 3; ++i) ASSERT_EQ(s.show(s.image(Vec2(9 * i, -5 * i))), Status::kOk);
  s.frontend->predict(Mat3::Identity());
  size_t old = 0;
  for (const Track& track : s.tracks()) {
    const Vec2 moves(track.x_pred - track.x, track.y_pred - track.y);
    if (track.age == 0) {
      EXPECT_LT(moves.norm(), 1e-3);
    } else {
      EXPECT_LT((moves - Vec2(9, -5)).norm(), 0.3);
      ++old;
    }
  }
  EXPECT_GT(old, 20u);
}

// Two tracks are missing in each image, as they are erased: the same best corners would come back.
TEST(frontend, empty_bins_are_searched_in_turn) {
  Slide s(4, 400, 300);
  s.params.tracks_target = 10;
  s.frontend->configure(s.camera, s.params);
  const DetectionGrid grid = detection_grid(400, 300, 36);
  const std::vector<uint8_t> image = s.image(Vec2(0, 0));
  std::set<int> bins;
  for (int i = 0; i < 20; ++i) {
    ASSERT_EQ(s.show(image), Status::kOk);
    EXPECT_EQ(s.tracks().size(), 10u);
    for (const Track& track : s.tracks()) {
      if (track.age > 0) continue;
      bins.insert((static_cast<int>(track.y) - 20) / 36 * grid.columns +
                  (static_cast<int>(track.x) - 20) / 36);
    }
    for (int k = 0; k < 2; ++k) s.frontend->erase(0);
  }
  EXPECT_GT(bins.size(), 18u) << "of " << grid.columns * grid.rows;
}

TEST(frontend, prediction_turns_with_the_camera) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  const Mat3 R_C1C0 = so3_exp(Vec3(0.02, -0.05, 0.1));
  s.frontend->predict(R_C1C0);
  for (const Track& track : s.tracks()) {
    const Vec3 ray(track.x - s.camera.cx, track.y - s.camera.cy, 150);
    const Vec3 turned = R_C1C0 * ray;
    EXPECT_NEAR(track.x_pred, s.camera.cx + 150 * turned.x() / turned.z(), 1e-3);
    EXPECT_NEAR(track.y_pred, s.camera.cy + 150 * turned.y() / turned.z(), 1e-3);
  }
}

TEST(frontend, what_leaves_the_image_is_dropped_and_counted) {
  Slide s;
  for (int i = 0; i < 30; ++i) {
    ASSERT_EQ(s.show(s.image(Vec2(-2.4 * i, 0))), Status::kOk);
    for (const Track& track : s.tracks()) {
      EXPECT_GE(track.x, 10);
      EXPECT_LE(track.x, kSide - 11);
    }
  }
  EXPECT_GT(s.lost(TrackLoss::kLeftImage), 0u);
  EXPECT_GE(s.lost(TrackLoss::kLeftImage) + s.lost(TrackLoss::kFlow), 5u) << "two columns left";
  EXPECT_GE(s.tracks().size(), 18u) << "bins that came in are filled again";
}

TEST(frontend, brightness_and_contrast_do_not_move_tracks) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  const size_t before = s.tracks().size();
  ASSERT_EQ(s.show(s.image(Vec2(1.4, 0.6), 0.6, 40)), Status::kOk);
  size_t followed = 0;
  for (const Track& track : s.tracks()) {
    if (track.age == 0) continue;
    ++followed;
    EXPECT_LT((Vec2(track.x - track.x_last, track.y - track.y_last) - Vec2(1.4, 0.6)).norm(), 0.15);
  }
  EXPECT_GE(followed, before * 9 / 10);
}

TEST(frontend, another_scene_ends_the_tracks) {
  Slide s, other(99);
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  const size_t before = s.tracks().size();
  ASSERT_EQ(s.show(other.image(Vec2(0, 0))), Status::kOk);
  size_t followed = 0;
  for (const Track& track : s.tracks()) followed += track.age > 0 ? 1 : 0;
  EXPECT_LE(followed, before / 8);
}

TEST(frontend, wrong_size_or_older_time_changes_nothing) {
  Slide s;
  const std::vector<uint8_t> pixels = s.image(Vec2(0, 0));
  ASSERT_EQ(s.show(pixels), Status::kOk);
  const Tracks before = s.tracks();
  const ImageView image{pixels.data(), kSide, kSide, kSide};
  const ImageView narrow{pixels.data(), kSide - 1, kSide, kSide};
  EXPECT_EQ(s.frontend->process(narrow, s.t + 1, kDown_C), Status::kBadData);
  EXPECT_EQ(s.frontend->process(image, s.t, kDown_C), Status::kBadData);
  EXPECT_EQ(s.frontend->process(image, s.t - 1, kDown_C), Status::kBadData);
  ASSERT_EQ(s.tracks().size(), before.size());
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(s.tracks()[i].id, before[i].id);
    EXPECT_EQ(s.tracks()[i].age, before[i].age);
  }
  EXPECT_EQ(s.frontend->process(image, s.t + 1, kDown_C), Status::kOk);
}

TEST(frontend, a_flat_image_has_no_tracks) {
  Slide s;
  s.params.corner_response_min = 1;
  s.frontend->configure(s.camera, s.params);
  ASSERT_EQ(s.show(std::vector<uint8_t>(kSide * kSide, 77)), Status::kOk);
  EXPECT_TRUE(s.tracks().empty());
}

TEST(frontend, of_two_tracks_that_run_together_the_older_stays) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  const Track elder = s.tracks()[0];
  const TrackId younger = s.frontend->start_track(elder.x + 2, elder.y, nullptr);
  ASSERT_NE(younger, 0u);
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  EXPECT_NE(s.find(elder.id), nullptr);
  EXPECT_EQ(s.find(younger), nullptr);
  EXPECT_EQ(s.lost(TrackLoss::kSpacing), 1u);
}

TEST(frontend, start_track_refuses_the_rim_and_a_full_list) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  EXPECT_EQ(s.frontend->start_track(5, 100, nullptr), 0u);
  EXPECT_EQ(s.frontend->start_track(100, kSide - 5, nullptr), 0u);
  Descriptor d{};
  d.w[2] = 12345;
  const TrackId id = s.frontend->start_track(100.5f, 101.25f, &d);
  ASSERT_NE(id, 0u);
  EXPECT_EQ(s.find(id)->descriptor.w[2], 12345u);
  while (!s.tracks().full()) ASSERT_NE(s.frontend->start_track(50, 50, nullptr), 0u);
  EXPECT_EQ(s.frontend->start_track(50, 50, nullptr), 0u);
}

TEST(frontend, nearest_is_the_nearest_within_the_radius) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  const Track first = s.tracks()[0];
  const Track* found = s.frontend->nearest(first.x + 1, first.y - 1, 2);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->id, first.id);
  EXPECT_EQ(s.frontend->nearest(first.x + 1, first.y - 1, 1), nullptr);
}

TEST(frontend, reset_drops_tracks_and_never_reuses_their_ids) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  TrackId newest = 0;
  for (const Track& track : s.tracks()) newest = std::max(newest, track.id);
  s.frontend->reset();
  EXPECT_TRUE(s.tracks().empty());
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  for (const Track& track : s.tracks()) EXPECT_GT(track.id, newest);
}

TEST(frontend, living_tracks_keep_slots_of_their_own) {
  Slide s;
  std::map<TrackId, uint16_t> slot_of;
  for (int k = 0; k < 30; ++k) {
    ASSERT_EQ(s.show(s.image(Vec2(9.0 * k, 0))), Status::kOk);
    if (k % 3 == 0) s.frontend->erase(s.tracks().size() / 2);
    std::set<uint16_t> taken;
    for (const Track& track : s.tracks()) {
      EXPECT_TRUE(taken.insert(track.slot).second) << "two tracks in slot " << track.slot;
      EXPECT_LT(track.slot, kTracksMax);
      const auto [known, fresh] = slot_of.insert({track.id, track.slot});
      EXPECT_TRUE(fresh || known->second == track.slot) << "a slot has changed";
    }
  }
  EXPECT_GT(slot_of.size(), 2 * s.tracks().size()) << "slots must have been used again";
}

TEST(frontend, a_note_of_a_dead_track_is_not_its_successors) {
  Slide s;
  ASSERT_EQ(s.show(s.image(Vec2(0, 0))), Status::kOk);
  auto notes = std::make_unique<TrackTable<int>>();
  const Track dead = s.tracks()[3];
  EXPECT_EQ(notes->find(dead), nullptr);
  (*notes)[dead] = 7;
  EXPECT_EQ(notes->get(dead), 7);
  s.frontend->erase(3);
  ASSERT_NE(s.frontend->start_track(dead.x, dead.y, nullptr), 0u);
  const Track next = s.tracks().back();
  ASSERT_EQ(next.slot, dead.slot) << "the last slot that was left is the next one taken";
  EXPECT_EQ(notes->find(next), nullptr);
  EXPECT_EQ((*notes)[next], 0);
  EXPECT_EQ(notes->find(dead), nullptr) << "nor is the successor's note the dead one's";
}

// The image is turned by a quarter; gravity turns along, so descriptors must not care.
TEST(frontend, descriptors_survive_a_roll) {
  Slide level, rolled;
  const std::vector<uint8_t> upright = level.image(Vec2(0, 0));
  std::vector<uint8_t> turned(upright.size());
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      turned[static_cast<size_t>(x * kSide + kSide - 1 - y)] =
          upright[static_cast<size_t>(y * kSide + x)];
    }
  }
  ASSERT_EQ(level.show(upright), Status::kOk);
  ASSERT_EQ(rolled.show(turned, Vec3(-9.81, 0, 0)), Status::kOk);
  int pairs = 0, alike = 0;
  for (const Track& track : level.tracks()) {
    const Track* same = rolled.frontend->nearest(kSide - 1 - track.y, track.x, 1.0f);
    if (same == nullptr) continue;
    ++pairs;
    alike += hamming(track.descriptor, same->descriptor) < 30 ? 1 : 0;
  }
  EXPECT_GE(pairs, 15);
  EXPECT_GE(alike, pairs * 9 / 10);
}

}  // namespace
}  // namespace pirvs
