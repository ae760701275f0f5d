// Exposure and gain through real controls of V4L2: a sensor that begins in the dark, light that
// changes at once, and another program that meddles; the pin that triggers it, seen from outside,
// and a pulse per second on another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
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

constexpr size_t kDim = 60, kMeddle = 110;
constexpr double kRate_ppb = 123'000;  // by how much the device's clock is fast: 1.000123 s a pulse

const DeviceRun& exposed_run() {
  static const DeviceRun run = [] {
    GuestSetup setup;
    setup.name = "device_exposure";
    // It begins with a tenth of the exposure that the recording was taken with.
    setup.camera = "exposure=4 dim_at=60 meddle_at=110 mplane=1";
    setup.grid = true;
    setup.robot = "9 1000123 0 pps";
    setup.config =
        "pin.trigger = TRIGGER\n"
        "trigger.rate_hz = 20\n"
        "trigger.width_us = 800\n"
        "pin.sync_in = SYNC_IN\n"
        "pin.sync_in_as = pps\n"
        "output.stream = 127.0.0.1:14560\n";
    return run_guest(fed_recording(), setup);
  }();
  return run;
}

TEST(device_exposure, settles_in_the_dark_after_a_change_and_after_another_program) {
  const DeviceRun& run = exposed_run();
  ASSERT_EQ(run.status, 0) << run.console;
  std::printf("%s%s", run.fed.c_str(), run.news.c_str());
  EXPECT_TRUE(run.says("pirvsd ended with 0")) << run.console;
  const std::vector<double> errors =
      errors_of(tools::open_recording(run.folder + "/record/0001", {}));
  for (size_t i = 0; i < errors.size(); ++i) std::printf("%.2f ", errors[i]);
  std::printf("\n");
  ASSERT_GT(errors.size(), 140u);
  EXPECT_LE(settled(errors, 0, 20), 10u) << "in the dark";
  const size_t after_dim = settled(errors, kDim + 1, 20),
               after_meddle = settled(errors, kMeddle + 1, 20);
  EXPECT_GT(errors[kDim + 1], 2) << "it is darker";
  EXPECT_LE(after_dim - kDim, 10u);
  EXPECT_LE(after_meddle - kMeddle, 10u) << "mostly undone before the next image";
  EXPECT_EQ(run.counter("camera.left.exposure_changed"), 1u);
  EXPECT_EQ(run.counter("camera.right.exposure_changed"), 1u);
  EXPECT_EQ(run.counter("camera.left.control_refused"), 0u);
  EXPECT_EQ(run.counter("camera.left.converted"), 0u) << "also by the multi-planar interface";
  EXPECT_GT(run.counter("output.lines"), errors.size() / 2) << "it tracks";
}

// Exposures of the left camera's images, by the point of the trigger's grid that is nearest.
std::map<TimeNs, TimeNs> exposures_of(const DeviceRun& run, TimeNs period) {
  std::map<TimeNs, TimeNs> out;
  std::istringstream log(text_of(run.folder + "/kernel"));
  for (std::string line; std::getline(log, line);) {
    const size_t at = line.find("test_camera0 exposed ");
    long long stamp = 0, exposure_us = 0;
    if (at == std::string::npos) continue;
    if (std::sscanf(line.c_str() + at, "test_camera0 exposed %lld for %lld", &stamp,
                    &exposure_us) != 2) {
      continue;
    }
    out[(stamp + period / 2) / period * period] = 1000 * exposure_us;
  }
  return out;
}

// The images do not come of the pulses here, but at the grid's points, as often: each pulse must
// stand half of its image's exposure before it.
TEST(device_exposure, a_pin_triggers_half_an_exposure_before_the_grid) {
  constexpr TimeNs kPeriod = 50'000'000, kTolerance = 100'000;
  const DeviceRun& run = exposed_run();
  ASSERT_EQ(run.status, 0) << run.console;
  const std::vector<TimeNs> up = run.robot_times("TRIGGER", 1);
  std::vector<TimeNs> down = run.robot_times("TRIGGER", 0);
  ASSERT_GT(up.size(), 200u) << "12.5 s at 20 Hz, but for the program's end";
  EXPECT_EQ(run.counter("trigger.left_out"), 0u);
  EXPECT_LE(run.counter("trigger.late"), 2u) << "the guest's clock leaps on a busy host";
  EXPECT_GE(run.counter("trigger.pulses"), up.size());
  const std::map<TimeNs, TimeNs> exposures = exposures_of(run, kPeriod);
  ASSERT_GT(exposures.size(), 100u);
  // Later commands than the sensor's delay wants, or another program's, show in the image itself.
  const auto known = [&](TimeNs point) {
    const auto image = static_cast<size_t>((point - exposures.begin()->first) / kPeriod);
    return image > 2 && (image < kMeddle || image > kMeddle + 3);
  };
  std::vector<TimeNs> off;
  TimeNs least = INT64_MAX, most = 0;
  for (size_t i = 0; i < up.size(); ++i) {
    const TimeNs point = (up[i] - kTolerance + kPeriod - 1) / kPeriod * kPeriod;
    if (i > 0) {
      const TimeNs before = (up[i - 1] - kTolerance + kPeriod - 1) / kPeriod * kPeriod;
      EXPECT_EQ(point - before, kPeriod) << "no pulse is missing, none is too many: " << i;
    }
    const auto image = exposures.find(point);
    if (image == exposures.end() || !known(point)) continue;
    const TimeNs lead = image->second / 2;
    off.push_back(std::abs(up[i] - (point - lead)));
    EXPECT_LT(off.back(), kTolerance)
        << "image of " << point << ", lead " << point - up[i] << " instead of " << lead;
    least = std::min(least, lead);
    most = std::max(most, lead);
  }
  ASSERT_GT(off.size(), 80u) << "of 154 at rest";
  std::sort(off.begin(), off.end());
  std::printf(
      "TRIGGER from half an exposure (%.1f to %.1f ms) before its point, us: median %.1f, "
      "p99 %.1f, max %.1f, of %zu\n",
      1e-6 * double(least), 1e-6 * double(most), 1e-3 * double(off[off.size() / 2]),
      1e-3 * double(off[off.size() * 99 / 100]), 1e-3 * double(off.back()), off.size());
  EXPECT_GT(most, 2 * least) << "the exposure did change";
  // The robot may begin to listen in the middle of a pulse.
  if (!down.empty() && down[0] < up[0]) down.erase(down.begin());
  for (size_t i = 0; i < std::min(up.size(), down.size()); ++i) {
    EXPECT_NEAR(double(down[i] - up[i]), 800e3, 100e3) << i;
  }
}

// What the stream says at each pulse, of a clock that runs beside the device's own.
TEST(pins, a_pulse_per_second_gives_the_rate_and_the_phase_of_its_clock) {
  constexpr double kNear_ns = 20e3, kNearInEnd_ppb = 2e3;
  const DeviceRun& run = exposed_run();
  ASSERT_EQ(run.status, 0) << run.console;
  const std::vector<TimeNs> pulses = run.robot_times("sync");
  ASSERT_GE(pulses.size(), 9u);
  EXPECT_EQ(run.counter("pin.sync_in_edges"), pulses.size());
  EXPECT_EQ(run.counter("pin.pps_odd"), 0u);
  size_t told = 2;  // a clock is known from the third on
  double rate_ppb = 0;
  std::istringstream all(run.pins);
  for (std::string line; std::getline(all, line);) {
    long long t = 0;
    double noise_ns = 0;
    unsigned count = 0, odd = 0;
    if (std::sscanf(line.c_str(), "pps %lld %lf %lf %u %u", &t, &rate_ppb, &noise_ns, &count,
                    &odd) != 5) {
      continue;
    }
    ASSERT_LT(told, pulses.size());
    const double off_ns = double(t - pulses[told]);
    std::printf("pulse %u: %.1f us from its second, rate %.1f ppb, noise %.1f us\n", count,
                1e-3 * off_ns, rate_ppb, 1e-3 * noise_ns);
    EXPECT_LT(std::abs(off_ns), kNear_ns) << told;
    EXPECT_NEAR(rate_ppb, kRate_ppb, 20e3) << told;
    EXPECT_LT(noise_ns, kNear_ns);
    EXPECT_EQ(count, ++told) << "one at each";
    EXPECT_EQ(odd, 0u);
  }
  EXPECT_EQ(told, pulses.size());
  EXPECT_NEAR(rate_ppb, kRate_ppb, kNearInEnd_ppb);
}

}  // namespace
}  // namespace pirvs::systems
