// Exposure and gain through real controls of V4L2: a sensor that begins in the dark, light that
// changes at once, and another program that meddles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "modules/exposure/brightness.h"
#include "modules/exposure/exposure_params.h"
#include "tests/device/guest_run.h"
#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

constexpr double kNear = 1.3;  // of the right grey, as a factor either way

// By what factor the grey of each frame should change, 1 or more.
std::vector<double> errors_of(const tools::Recording& recording) {
  const ExposureParams params;
  std::vector<double> out;
  for (const tools::FrameFiles& frame : recording.frames) {
    Histogram histogram;
    for (const std::string& file : frame.image) {
      const cv::Mat image = cv::imread(file, cv::IMREAD_GRAYSCALE);
      add({image.data, image.cols, image.rows, int(image.step)}, histogram);
    }
    const double factor =
        correction(histogram, double(params.mean_grey), double(params.highlights));
    out.push_back(std::max(factor, 1 / factor));
  }
  return out;
}

// The first frame from `from` on after which `count` are near.
size_t settled(const std::vector<double>& errors, size_t from, size_t count) {
  for (size_t i = from; i + count <= errors.size(); ++i) {
    const auto near = [](double error) { return error < kNear; };
    if (std::all_of(&errors[i], &errors[i] + count, near)) return i;
  }
  return errors.size();
}

TEST(device_exposure, settles_in_the_dark_after_a_change_and_after_another_program) {
  GuestSetup setup;
  setup.name = "device_exposure";
  constexpr size_t kDim = 60, kMeddle = 110;
  // It begins with a tenth of the exposure that the recording was taken with.
  setup.camera = "exposure=4 dim_at=60 meddle_at=110";
  const DeviceRun run = run_guest(fed_recording(), setup);
  ASSERT_EQ(run.status, 0) << run.console;
  std::printf("%s%s", run.fed.c_str(), run.news.c_str());
  EXPECT_TRUE(run.says("pirvsd ended with 0")) << run.console;
  const std::vector<double> errors = errors_of(tools::open_recording(run.folder + "/record", {}));
  for (size_t i = 0; i < errors.size(); ++i) std::printf("%.2f ", errors[i]);
  std::printf("\n");
  ASSERT_GT(errors.size(), 140u);
  EXPECT_LE(settled(errors, 0, 20), 10u) << "in the dark";
  const size_t after_dim = settled(errors, kDim + 1, 20),
               after_meddle = settled(errors, kMeddle + 1, 20);
  EXPECT_GT(errors[kDim + 1], 2) << "it is darker";
  EXPECT_LE(after_dim - kDim, 10u);
  EXPECT_GT(after_meddle, kMeddle + 1) << "the other program was seen";
  EXPECT_LE(after_meddle - kMeddle, 10u);
  EXPECT_EQ(run.counter("camera.left.exposure_changed"), 1u);
  EXPECT_EQ(run.counter("camera.right.exposure_changed"), 1u);
  EXPECT_EQ(run.counter("camera.left.control_refused"), 0u);
  EXPECT_GT(run.counter("output.lines"), errors.size() / 2) << "it tracks";
}

}  // namespace
}  // namespace pirvs::systems
