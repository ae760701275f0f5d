#include "modules/tracking/recent_frames.h"

#include <gtest/gtest.h>

#include <memory>

namespace pirvs {
namespace {

constexpr TimeNs kStep = 50'000'000;

// Track i is at (10 i + frame, frame) in each frame.
struct Shown {
  explicit Shown(int count) {
    for (int i = 0; i < count; ++i) {
      Track track{};
      track.id = static_cast<TrackId>(i + 1);
      track.slot = static_cast<uint16_t>(i);
      (void)tracks.push_back(track);
    }
  }
  void show(int frame) {
    recent->add(frame * kStep);
    for (size_t i = 0; i < tracks.size(); ++i) {
      tracks[i].x = 10.0f * static_cast<float>(i) + static_cast<float>(frame);
      tracks[i].y = static_cast<float>(frame);
    }
    recent->note(0, tracks);
  }
  Tracks tracks;
  std::unique_ptr<RecentFrames> recent = std::make_unique<RecentFrames>();
};

TEST(recent_frames, keep_the_places_of_the_last) {
  Shown s(3);
  for (int frame = 0; frame < 40; ++frame) s.show(frame);
  ASSERT_EQ(s.recent->end() - s.recent->begin(), RecentFrames::kFramesMax);
  for (uint32_t frame = s.recent->begin(); frame < s.recent->end(); ++frame) {
    EXPECT_EQ(s.recent->time(frame), frame * kStep);
    Vec2 uv;
    ASSERT_TRUE(s.recent->place(0, s.tracks[2], frame, uv));
    EXPECT_EQ(uv, Vec2(20 + frame, frame));
    EXPECT_FALSE(s.recent->place(1, s.tracks[2], frame, uv)) << "the other camera showed nothing";
  }
  Vec2 uv;
  EXPECT_FALSE(s.recent->place(0, s.tracks[2], s.recent->begin() - 1, uv)) << "written over";
  EXPECT_TRUE(s.recent->covers(30 * kStep));
  EXPECT_FALSE(s.recent->covers(20 * kStep));
  s.recent->clear();
  EXPECT_FALSE(s.recent->covers(40 * kStep));
  EXPECT_EQ(s.recent->begin(), s.recent->end());
}

TEST(recent_frames, a_track_has_no_place_before_it_began_nor_while_it_was_hidden) {
  Shown s(2);
  s.show(0);
  s.show(1);
  const Track gone = s.tracks[1];
  s.tracks[1].id = 77;  // takes the slot
  s.show(2);
  s.recent->add(3 * kStep);  // this camera is missing
  s.show(4);
  Vec2 uv;
  for (const uint32_t frame : {0u, 1u, 3u}) {
    EXPECT_FALSE(s.recent->place(0, s.tracks[1], frame, uv)) << frame;
  }
  for (const uint32_t frame : {2u, 4u}) EXPECT_TRUE(s.recent->place(0, s.tracks[1], frame, uv));
  for (uint32_t frame = 0; frame < 5; ++frame) EXPECT_FALSE(s.recent->place(0, gone, frame, uv));
  EXPECT_TRUE(s.recent->place(0, s.tracks[0], 1, uv));
  EXPECT_FALSE(s.recent->place(0, s.tracks[0], 3, uv));
}

}  // namespace
}  // namespace pirvs
