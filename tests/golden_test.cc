// Golden replays: what the estimator gives on a few seconds of five recordings, digit by digit,
// against values in tests/golden/. A change of the estimator shows here, wanted or not.
// In      tests/golden/NAME.txt, found from the working directory; PIRVS_RENEW=1 rewrites them.
// Out     Once a second the pose and its sigmas; counters; ATE. The lines that differ are printed.
// Units   ns; m, and the nine elements of R_WB; mm and mrad for the sigmas; mm for the ATE.
// Errors  A test fails when a digit differs or a file is missing: `make golden` shows the lines,
//         `make golden RENEW=1` renews them; the commit says why.
// Cost    ~20 s of one core.
// Source  STYLE 14. The same bits on each machine: -ffp-contract=off, no libm below tools. The
//         simulator does call libm: its recordings may differ under another C library.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

constexpr double kClip_s = 10;
constexpr double kPosePeriod_s = 1;
constexpr const char* kCounters[] = {
    "frames",           "frames_with_pose",      "starts",        "losses",
    "track_flow",       "track_residual",        "stereo_found",  "gate_accepted",
    "gate_chi2",        "matched_by_projection", "keyframes",     "keyframes_dropped",
    "adjustments",      "adjustments_failed",    "points_stereo", "points_temporal",
    "points_removed",   "points_rejected",       "bundle_full",   "observations_removed",
    "standstill_frames"};

std::string text(const char* format, double value) {
  char out[64];
  std::snprintf(out, sizeof out, format, value);
  return out;
}

std::string pose_line(const FusedState& pose) {
  const SE3& T_WB = pose.state.T_WB;
  std::string out = "pose " + std::to_string(pose.state.t);
  for (int i = 0; i < 3; ++i) out += text(" %.6f", T_WB.p[i]);
  for (int i = 0; i < 9; ++i) out += text(" %.6f", T_WB.R(i / 3, i % 3));
  out += " sigma_mrad";
  for (int i = 0; i < 3; ++i) out += text(" %.6f", 1e3 * std::sqrt(pose.cov(i, i)));
  out += " sigma_mm";
  for (int i = 3; i < 6; ++i) out += text(" %.6f", 1e3 * std::sqrt(pose.cov(i, i)));
  return out;
}

std::vector<std::string> told(const Replay& run) {
  std::vector<std::string> lines;
  TimeNs next = 0;
  for (const FrameReport& frame : run.log.frames) {
    if (!frame.has_pose || frame.t < next) continue;
    lines.push_back(pose_line(frame.pose));
    next = frame.t + from_seconds(kPosePeriod_s);
  }
  for (const char* name : kCounters) {
    lines.push_back(std::string(name) + " " + std::to_string(run.counter(name)));
  }
  lines.push_back(text("ate_rmse_mm %.6f", 1e3 * run.result.evaluation.ate_rmse_m));
  return lines;
}

void compare(const std::string& name, const Replay& run) {
  const std::string path = "tests/golden/" + name + ".txt";
  std::vector<std::string> stored;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) stored.push_back(line);
  const std::vector<std::string> now = told(run);
  size_t differ = 0;
  for (size_t i = 0; i < std::max(stored.size(), now.size()); ++i) {
    const std::string before = i < stored.size() ? stored[i] : "";
    const std::string after = i < now.size() ? now[i] : "";
    if (before == after) continue;
    ++differ;
    std::printf("- %s\n+ %s\n", before.c_str(), after.c_str());
  }
  const char* const renew = std::getenv("PIRVS_RENEW");
  if (renew == nullptr || std::string(renew) != "1") {
    EXPECT_EQ(differ, 0u) << "lines of " << path << "; on purpose: make golden RENEW=1";
    return;
  }
  std::ofstream out(path);
  for (const std::string& line : now) out << line << "\n";
  ASSERT_TRUE(out.good()) << path;
}

class golden_clip : public testing::Test {
 protected:
  void SetUp() override {
    if (clip() == nullptr) GTEST_SKIP() << "the real recording is not on this machine";
  }
  static tools::Recording part(bool mono) {
    tools::RecordingOptions options;
    options.duration_s = kClip_s;
    options.mono = mono;
    return tools::open_recording(clip()->folder, options);
  }
};

TEST_F(golden_clip, stereo) { compare("clip_stereo", replay(part(false))); }

TEST_F(golden_clip, mono) { compare("clip_mono", replay(part(true))); }

TEST_F(golden_clip, with_a_camera_missing_and_an_imu_gap) {
  compare("clip_faults", replay(part(false), {1, {"cam1:3-5", "imu:7-7.1"}}));
}

TEST(golden_simulated, euroc) { compare("sim_euroc", replay(simulated(SimulatedDevice::kEuroc))); }

TEST(golden_simulated, ironsides) {
  compare("sim_ironsides", replay(simulated(SimulatedDevice::kIronsides)));
}

}  // namespace
}  // namespace pirvs::systems
