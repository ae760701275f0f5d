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
  setup.camera = "exposure=4";  // a tenth of what the recording was taken with
  // The recording begins 2 s after the feeder.
  setup.meanwhile =
      "cd /sys/module/test_camera/parameters; sleep 5; echo 30 > light; sleep 2; echo 3 > meddle";
  const DeviceRun run = run_guest(fed_recording(), setup);
  ASSERT_EQ(run.status, 0) << run.console;
  std::printf("%s%s", run.fed.c_str(), run.news.c_str());
  EXPECT_TRUE(run.says("pirvsd ended with 0")) << run.console;
  const std::vector<double> errors = errors_of(tools::open_recording(run.folder + "/record", {}));
  for (size_t i = 0; i < errors.size(); ++i) std::printf("%.2f ", errors[i]);
  std::printf("\n");
  ASSERT_GT(errors.size(), 140u);
  EXPECT_LE(settled(errors, 0, 20), 10u) << "in the dark";
  // What was near and is far, later on: the light, and the other program.
  std::vector<size_t> changes;
  for (size_t i = 20; i < errors.size(); ++i) {
    if (errors[i] > 2 && errors[i - 1] < kNear) changes.push_back(i);
  }
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_LE(settled(errors, changes[0], 10) - changes[0], 10u) << "light";
  EXPECT_LE(settled(errors, changes[1], 10) - changes[1], 10u) << "another program";
  EXPECT_EQ(run.counter("camera.left.exposure_changed"), 1u);
  EXPECT_EQ(run.counter("camera.right.exposure_changed"), 1u);
  EXPECT_EQ(run.counter("camera.left.control_refused"), 0u);
  EXPECT_GT(run.counter("output.lines"), errors.size() / 2) << "it tracks";
}

}  // namespace
}  // namespace pirvs::systems
