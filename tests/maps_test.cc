// A map that was saved is a place to be found again, and no other place is taken for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/map/map_files.h"

namespace pirvs::systems {
namespace {

using tools::Recording;

// Turn about the vertical and shift that lay a run on the truth.
struct Laid {
  double yaw_rad = 0;
  Vec3 shift = Vec3::Zero();
  Vec3 operator*(const Vec3& p) const {
    const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
    return Vec3(c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z()) + shift;
  }
};

const tools::TrajectoryPose* truth_at(const Recording& recording, TimeNs t) {
  const auto& poses = recording.truth.poses;
  const auto at =
      std::lower_bound(poses.begin(), poses.end(), t,
                       [](const tools::TrajectoryPose& p, TimeNs time) { return p.t < time; });
  return at == poses.end() ? nullptr : &*at;
}

template <class Visit>
void for_each_pose(const Replay& run, const Recording& recording, Visit&& visit) {
  for (const FrameReport& frame : run.log.frames) {
    const auto* const truth = truth_at(recording, frame.t);
    if (frame.has_pose && truth != nullptr) visit(frame, truth->p_WB);
  }
}

Laid lay(const Replay& run, const Recording& recording) {
  Vec3 mean_e = Vec3::Zero(), mean_t = Vec3::Zero();
  double count = 0, sine = 0, cosine = 0;
  for_each_pose(run, recording, [&](const FrameReport& frame, const Vec3& truth) {
    mean_e += frame.pose.state.T_WB.p, mean_t += truth, ++count;
  });
  mean_e /= count, mean_t /= count;
  for_each_pose(run, recording, [&](const FrameReport& frame, const Vec3& truth) {
    const Vec3 e = frame.pose.state.T_WB.p - mean_e, t = truth - mean_t;
    cosine += e.x() * t.x() + e.y() * t.y(), sine += e.x() * t.y() - e.y() * t.x();
  });
  Laid out{std::atan2(sine, cosine), Vec3::Zero()};
  out.shift = mean_t - out * mean_e;
  return out;
}

double rms_in_map(const Replay& run, const Recording& recording, const Laid& map) {
  double sum = 0, count = 0;
  for_each_pose(run, recording, [&](const FrameReport& frame, const Vec3& truth) {
    if (!frame.pose.in_map) return;
    sum += (map * frame.pose.state.T_WB.p - truth).squaredNorm(), ++count;
  });
  return std::sqrt(sum / count);
}

Recording flight(uint64_t room, uint64_t seed, double duration_s, bool another_day) {
  tools::SimOptions options;
  options.room = room;
  options.seed = seed;
  options.duration_s = duration_s;
  options.rest_s = 0.5;
  options.boxes = 80;
  options.blur = 2;
  options.format = "pgm";
  if (another_day) {
    options.gone = 0.3;
    options.relit = true;
    options.movers = 4;
    options.dark = 0.33;
  }
  return made(options, "room" + std::to_string(room) + "_" + std::to_string(seed));
}

class Maps : public testing::Test {
 protected:
  Maps() : file_(scratch_folder("maps") + "/hall.map") {}
  Replay save(const Recording& recording) {
    ReplayOptions options;
    options.save_map = file_;
    return replay(recording, options);
  }
  Replay in_map(const Recording& recording, bool extend = true) {
    ReplayOptions options;
    options.load_map = file_;
    options.extend_map = extend;
    return replay(recording, options);
  }
  std::string file_;
};

TEST_F(Maps, are_found_again_on_another_day_and_no_other_room_is) {
  const Recording monday = flight(1, 1, 25, false), tuesday = flight(1, 100, 4, true);
  const Replay first = save(monday);
  const Laid world = lay(first, monday);
  for (const bool extend : {true, false}) {
    const Replay again = in_map(tuesday, extend);
    const double rms = rms_in_map(again, tuesday, world);
    std::printf("localised after %.2f s, %.4f m rms in the map's frame\n",
                again.result.localised_after_s, rms);
    ASSERT_GE(again.result.localised_after_s, 0);
    EXPECT_LT(again.result.localised_after_s, 3);
    EXPECT_LT(rms, 0.03);
    expect_no_failures(again);
  }
  // Looks at first where Monday did not, at a wall with the paper of one that it saw.
  const Recording wallpaper = flight(1, 103, 5, true);
  const Replay later = in_map(wallpaper);
  const double rms = rms_in_map(later, wallpaper, world);
  std::printf("localised after %.2f s, %.4f m rms\n", later.result.localised_after_s, rms);
  EXPECT_GT(later.result.localised_after_s, 1);
  EXPECT_LT(rms, 0.06);  // 0.036; that wallpaper hangs 5.5 m away
  const Recording elsewhere = flight(2, 103, 4, false);
  const Replay lost = in_map(elsewhere);
  EXPECT_LT(lost.result.localised_after_s, 0) << "another room";
  EXPECT_LT(lost.result.evaluation.ate_rmse_m, 0.02) << "it tracks in a frame of its own";
  EXPECT_EQ(lost.log.frames.back().pose.health, HealthState::kTracking);
  const FusedState& end = lost.log.frames.back().pose;
  EXPECT_LT(std::sqrt(end.cov(3, 3)), 0.5) << "about its own start";
}

TEST_F(Maps, of_the_clips_first_half_hold_its_second) {
  if (clip() == nullptr) GTEST_SKIP() << "no clip";
  tools::RecordingOptions first_half, second_half;
  first_half.duration_s = 15;
  second_half.start_s = 16;
  const Recording first = tools::open_recording(clip()->folder, first_half);
  const Recording second = tools::open_recording(clip()->folder, second_half);
  const Replay saved = save(first);
  const Laid world = lay(saved, first);
  const Replay run = in_map(second);
  const double rms = rms_in_map(run, second, world);
  std::printf("localised after %.2f s, %.4f m rms\n", run.result.localised_after_s, rms);
  ASSERT_GE(run.result.localised_after_s, 0);
  EXPECT_LT(run.result.localised_after_s, 3);
  EXPECT_LT(rms, 0.03);
}

}  // namespace
}  // namespace pirvs::systems
