// What the calibration says of time and is not so: told, and corrected where that is asked for.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

constexpr TimeNs kLate = 20'000'000;

// Of the clip, whose stamps are right to the microsecond; a simulated flight of some seconds is too
// short to correct 20 ms.
Replay late_by(TimeNs offset, bool estimate) {
  tools::Recording recording = *clip();
  recording.calibration.camera_time_offset_ns += offset;
  ReplayOptions options;
  options.estimate_time = estimate;
  const Replay out = replay(recording, options);
  print(estimate ? "offset estimated" : "offset as in the calibration", out);
  const double sigma_ms = 1e3 * out.log.calibration.time_sigma_s;
  std::printf("  of %.0f ms: corrected %.2f, left %.2f +- %.2f ms\n", 1e-6 * double(offset),
              1e-6 * double(out.log.camera_correction), 1e3 * out.log.calibration.time_s, sigma_ms);
  return out;
}

TEST(self_calibration, right_stamps_are_found_right_and_left_alone) {
  if (clip() == nullptr) GTEST_SKIP();
  const Replay aligned = late_by(0, false);
  EXPECT_TRUE(aligned.log.calibration_news[0].empty()) << aligned.log.calibration_news[0];
  EXPECT_TRUE(aligned.log.calibration_news[1].empty()) << aligned.log.calibration_news[1];
  EXPECT_LT(std::fabs(aligned.log.calibration.time_s), 0.5e-3);
  EXPECT_EQ(aligned.log.camera_correction, 0);
}

TEST(self_calibration, an_offset_is_told_and_corrected) {
  if (clip() == nullptr) GTEST_SKIP();
  double error_told = 0, error_corrected = 0;
  for (const TimeNs offset : {kLate, -kLate}) {
    const Replay told = late_by(offset, false);
    EXPECT_NE(told.log.calibration_news[0].find(offset > 0 ? "older" : "newer"), std::string::npos)
        << told.log.calibration_news[0];
    EXPECT_EQ(told.log.camera_correction, 0);
    const Replay corrected = late_by(offset, true);
    EXPECT_NEAR(1e-6 * double(corrected.log.camera_correction), -1e-6 * double(offset), 0.5);
    error_told += told.result.evaluation.ate_rmse_m;
    error_corrected += corrected.result.evaluation.ate_rmse_m;
  }
  // The start in motion, before anything is corrected, suffers all the same.
  EXPECT_LT(error_corrected, 0.85 * error_told);
}

}  // namespace
}  // namespace pirvs::systems
