// SLAM and GNSS together, through the whole stack, against exact truth on the Earth.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "tests/recordings.h"
#include "tests/replay.h"
#include "tools/dataset/gnss_file.h"

namespace pirvs::systems {
namespace {

// A flight of 14 s: 13 m.
const tools::Recording& flight() {
  static const tools::Recording recording = [] {
    tools::SimOptions options;
    options.duration_s = 14;
    options.blur = 1;
    options.format = "jpg";
    return made(options, "gnss_flight");
  }();
  return recording;
}

// The flight with a receiver on board.
tools::Recording with(const tools::GnssOptions& gnss, const std::string& name) {
  tools::SimOptions options;
  options.gnss = gnss;
  options.gnss_of = flight().folder;
  options.out = scratch_folder(name);
  tools::simulate(options, [](size_t, size_t) {});
  tools::RecordingOptions how;
  how.gnss = options.out + "/data.csv";
  return tools::open_recording(flight().folder, how);
}

tools::GnssOptions rtk() {
  tools::GnssOptions gnss;
  gnss.kind = "rtk";
  gnss.antenna = {0.2, -0.1, 0.5};
  gnss.latency_s = 0.15;
  return gnss;
}

void print_fused(const char* what, const Replay& run) {
  const tools::FusedResult& f = run.result.fused_result;
  std::printf("%s: ATE %.4f m, with a heading %.4f m, fixes %.3f m, heading %.2f deg, NEES %.2f\n",
              what, f.ate_rmse_m, f.aligned_rmse_m, f.fixes_rmse_m, f.heading_rmse_deg,
              f.nees_position);
}

const Replay& rtk_run() {
  static const Replay run = replay(with(rtk(), "gnss_rtk"));
  return run;
}

TEST(gnss, rtk_and_slam_are_a_pose_on_the_earth) {
  const Replay& run = rtk_run();
  print_fused("rtk", run);
  const tools::FusedResult& fused = run.result.fused_result;
  ASSERT_TRUE(fused.ok);
  EXPECT_EQ(run.result.fused.back().health, FusionHealth::kFused);
  EXPECT_EQ(run.counter("fusion_aligned"), 1u);
  EXPECT_LT(fused.aligned_rmse_m, 0.03);
  EXPECT_LT(fused.heading_rmse_deg, 1.0);
  EXPECT_LT(fused.nees_position, 8.0);
  // A row for each frame since the first fix; late fixes have none of their own.
  EXPECT_GT(run.result.fused.size(), run.result.frames_tracked);
  for (size_t i = 1; i < run.result.fused.size(); ++i) {
    EXPECT_GT(run.result.fused[i].t, run.result.fused[i - 1].t);
  }
}

TEST(gnss, slam_is_the_same_with_and_without) {
  const Replay alone = replay(flight());
  EXPECT_TRUE(alone.trajectory() == rtk_run().trajectory());
  EXPECT_TRUE(alone.result.fused.empty());
}

TEST(gnss, several_cores_in_lockstep_give_the_same_bytes) {
  ReplayOptions two;
  two.cores = 2;
  two.playback = tools::Playback::kLockstep;
  const Replay run = replay(with(rtk(), "gnss_two"), two);
  EXPECT_TRUE(tools::fused_tum(run.result.fused) == tools::fused_tum(rtk_run().result.fused));
  EXPECT_TRUE(tools::fused_csv(run.result.fused) == tools::fused_csv(rtk_run().result.fused));
}

TEST(gnss, a_recorded_run_gives_the_fused_bytes_again) {
  ReplayOptions options;
  options.record = scratch_folder("gnss_record");
  const Replay run = replay(with(rtk(), "gnss_live"), options);
  const tools::Recording recorded = tools::open_recording(options.record, {});
  EXPECT_EQ(recorded.calibration.gnss.p_BA, Vec3(0.2, -0.1, 0.5));
  const Replay again = replay(recorded);
  EXPECT_GT(run.result.fused.size(), 250u);
  EXPECT_TRUE(tools::fused_csv(run.result.fused) == tools::fused_csv(again.result.fused));
}

TEST(gnss, fixes_of_metres_are_better_together) {
  tools::GnssOptions gnss;
  gnss.kind = "spp";
  const Replay run = replay(with(gnss, "gnss_spp"));
  print_fused("spp", run);
  ASSERT_TRUE(run.result.fused_result.ok);
  EXPECT_LT(run.result.fused_result.ate_rmse_m, 0.7 * run.result.fused_result.fixes_rmse_m);
}

TEST(gnss, an_outage_and_multipath_move_little) {
  tools::GnssOptions gnss = rtk();
  gnss.outage_from_s = 9, gnss.outage_for_s = 10;
  const Replay out = replay(with(gnss, "gnss_outage"));
  print_fused("outage", out);
  EXPECT_EQ(out.result.fused.back().health, FusionHealth::kSlamOnly);
  EXPECT_LT(out.result.fused_result.error_at_end_m, 0.1);
  gnss = rtk();
  gnss.multipath_m = 30, gnss.multipath_from_s = 9, gnss.multipath_for_s = 10;
  const Replay multipath = replay(with(gnss, "gnss_multipath"));
  print_fused("multipath", multipath);
  EXPECT_GT(multipath.counter("fixes_position_rejected"), 15u);
  EXPECT_LT(multipath.result.fused_result.error_at_end_m, 0.1);
}

}  // namespace
}  // namespace pirvs::systems
