#include <gtest/gtest.h>

#include <cmath>

#include "tools/dataset/input_error.h"
#include "tools/report/figure.h"
#include "tools/report/page.h"
#include "tools/report/report.h"
#include "tools/run/parameters.h"
#include "tools/run/result.h"

namespace pirvs::tools {
namespace {

constexpr TimeNs kBegin = 1'500'000'000'000'000'000;

// 100 frames at 20 Hz: 10 before the start, then a straight flight, the last `lost` ones lost.
RunLog make_log(int lost) {
  RunLog log(100);
  for (int i = 0; i < 100; ++i) {
    FrameReport frame;
    frame.t = kBegin + i * TimeNs{50'000'000};
    frame.has_pose = i >= 10;
    frame.pose.health = i < 10           ? HealthState::kInitializing
                        : i < 100 - lost ? HealthState::kTracking
                                         : HealthState::kLost;
    frame.pose.trust.confidence = i == 50 ? 0.25f : 0.75f;
    frame.pose.trust.resets = i < 10 ? 0 : i < 50 ? 1 : 3;
    frame.pose.trust.jump_m = i < 50 ? 0.0f : 0.125f;
    frame.pose.state.t = frame.t;
    frame.pose.cov.setZero();
    frame.pose.state.T_WB.p = Vec3(0.1 * i, 0.01 * i, 0);
    frame.image_ms = float(i + 1);
    frame.end_to_end_ms = float(2 * (i + 1));
    log.frames.push_back(frame);
  }
  log.health.push_back({kBegin, HealthState::kTracking, "started <in motion>"});
  log.counters = {{"gate_chi2", 3}, {"gate_behind", 0}};
  log.pools = {{"map", 1000}, {"filter", 24}};
  return log;
}

Recording make_recording() {
  Recording recording;
  for (int i = 0; i < 100; ++i) {
    FrameFiles frame;
    frame.t = kBegin + i * TimeNs{50'000'000};
    recording.frames.push_back(frame);
    TrajectoryPose pose;
    pose.t = frame.t;
    pose.t_s = double(pose.t) / 1e9;
    pose.p_WB = Vec3(0.1 * i, 0.01 * i, 0.02 * std::sin(0.3 * i));
    recording.truth.poses.push_back(pose);
  }
  return recording;
}

TEST(run, statistics_are_nearest_ranks) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const Statistics s = statistics(values);
  EXPECT_DOUBLE_EQ(s.mean, 50.5);
  EXPECT_EQ(s.median, 50);
  EXPECT_EQ(s.p95, 95);
  EXPECT_EQ(s.p99, 99);
  EXPECT_EQ(s.max, 100);
  EXPECT_EQ(statistics({}).max, 0);
  EXPECT_EQ(statistics({7}).p99, 7);
}

TEST(run, result_counts_frames_and_judges) {
  const Recording recording = make_recording();
  const RunResult good = make_result(recording, make_log(0), Status::kOk);
  EXPECT_EQ(good.frames_in, 100u);
  EXPECT_EQ(good.frames_before_start, 10u);
  EXPECT_EQ(good.frames_tracked, 90u);
  EXPECT_EQ(good.frames_lost, 0u);
  EXPECT_EQ(good.frames_dropped, 0u);
  EXPECT_EQ(good.pool_bytes, 1024u);
  EXPECT_EQ(good.exit_status(), 0);
  EXPECT_TRUE(good.evaluation.ok);
  EXPECT_LT(good.evaluation.ate_rmse_m, 0.02);
  EXPECT_EQ(good.timing[0].max, 100);
  EXPECT_EQ(good.resets, 3u);
  ASSERT_EQ(good.jumps.size(), 2u) << "two in one frame are told as one";
  EXPECT_EQ(good.jumps[1].t, kBegin + 50 * TimeNs{50'000'000});
  EXPECT_FLOAT_EQ(good.jumps[1].jump_m, 0.125f);
  EXPECT_FLOAT_EQ(good.confidence_min, 0.25f);
  const RunResult bad = make_result(recording, make_log(5), Status::kOk);
  EXPECT_EQ(bad.frames_lost, 5u);
  EXPECT_EQ(bad.exit_status(), 1);
  EXPECT_EQ(make_result(recording, RunLog(0), Status::kBadData).exit_status(), 1);
  RunLog short_log = make_log(0);
  short_log.frames.resize(60);  // stopped two seconds early, in good health
  EXPECT_EQ(make_result(recording, short_log, Status::kOk).frames_dropped, 40u);
  EXPECT_EQ(make_result(recording, short_log, Status::kOk).exit_status(), 1);
}

TEST(run, parameters_are_set_by_name_and_checked) {
  AppParams params;
  set_parameter(params, "lk_levels=3");
  EXPECT_EQ(params.frontend.lk_levels, 3);
  set_parameter(params, "frontend.lk_levels=2");
  EXPECT_EQ(params.frontend.lk_levels, 2);
  for (const char* bad :
       {"lk_levels", "lk_levels=", "lk_levels=two", "lk_levels=1000", "lk_levels=2.5", "nothing=1",
        "filter.lk_levels=3", "lk_levels=nan", "sigma_px=1"}) {
    EXPECT_THROW(set_parameter(params, bad), InputError) << bad;
  }
  const std::string all = list_parameters(params, true), user = list_parameters(params, false);
  EXPECT_NE(all.find("frontend.lk_levels"), std::string::npos);
  EXPECT_EQ(user.find("frontend.lk_levels"), std::string::npos);
  EXPECT_NE(all.find("frontend.tracks_target"), std::string::npos);
  EXPECT_NE(user.find("frontend.tracks_target"), std::string::npos);
}

TEST(report, is_one_file_and_escapes_what_it_shows) {
  const Recording recording = make_recording();
  const RunLog log = make_log(3);
  const RunResult result = make_result(recording, log, Status::kOk);
  const RunInfo info = {"pirvs run <a> --out 'b'", "/data/<a>/", "abc123", 1, {}};
  const std::string page = make_report(info, recording, log, result, {{"images_missing", 2}});
  for (const char* loaded : {"<script src", "<link", "@import", "url(http", "<img"}) {
    EXPECT_EQ(page.find(loaded), std::string::npos) << loaded;
  }
  for (const char* shown : {"Top view", "Side view", "gate_chi2", "images_missing", "End-to-end",
                            "started &lt;in motion&gt;", "pirvs run &lt;a&gt;", "abc123"}) {
    EXPECT_NE(page.find(shown), std::string::npos) << shown;
  }
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST(report, works_without_truth_poses_or_frames) {
  Recording recording = make_recording();
  recording.truth.poses.clear();
  for (const RunLog& log : {RunLog(0), make_log(0)}) {
    const RunResult result = make_result(recording, log, Status::kBadData);
    const std::string page = make_report({}, recording, log, result, {});
    EXPECT_EQ(page.find("Error over time"), std::string::npos);
    EXPECT_NE(page.find("</html>"), std::string::npos);
  }
}

TEST(figure, thins_long_series_but_keeps_the_spikes) {
  Figure figure;
  Series series{"a", "s1", {}, {}, false};
  for (int i = 0; i < 100000; ++i) {
    series.x.push_back(i);
    series.y.push_back(i == 54321 ? 100 : 0);
  }
  series.y[7] = NAN;
  figure.series.push_back(series);
  const std::string svg = figure.svg();
  EXPECT_LT(svg.size(), 60000u);
  EXPECT_NE(svg.find(">100<"), std::string::npos);  // the axis reaches the spike
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

}  // namespace
}  // namespace pirvs::tools
