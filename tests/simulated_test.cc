// The whole stack on simulated flights of both devices, with exact truth.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>

#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

// Of the path, 1.5 times what is reached.
constexpr double kEuroc_max = 0.0017, kIronsides_max = 0.0027;

// Shared: a run takes seconds.
const Replay& euroc_run() {
  static const Replay run = replay(simulated(SimulatedDevice::kEuroc));
  return run;
}

void expect_tracked(const Replay& run, double ate_of_path_max) {
  EXPECT_EQ(run.status, Status::kOk);
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_LE(run.first_pose_s(), 2.0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_EQ(run.result.frames_dropped, 0u);
  expect_no_failures(run);
  ASSERT_TRUE(run.result.evaluation.ok);
  EXPECT_LE(run.ate_of_path(), ate_of_path_max);
}

TEST(simulated_flight, euroc_is_tracked) {
  print("euroc", euroc_run());
  expect_tracked(euroc_run(), kEuroc_max);
}

// NEES is 3 where the covariance is honest; the filter's alone gives 1000. One flight says no more.
TEST(simulated_flight, the_covariance_contains_the_error) {
  const tools::Nees& nees = euroc_run().result.nees;
  ASSERT_TRUE(nees.ok);
  for (int part = 0; part < tools::kNeesParts; ++part) {
    EXPECT_LT(nees.mean[part], 10) << tools::kNeesNames[part];
    EXPECT_GT(nees.mean[part], 0.05) << tools::kNeesNames[part];
  }
}

TEST(simulated_flight, ironsides_fisheyes_are_tracked) {
  const Replay run = replay(simulated(SimulatedDevice::kIronsides));
  print("ironsides", run);
  expect_tracked(run, kIronsides_max);
}

// Other sizes and lenses with the same parameters: 512 x 512, 848 x 800, 1280 x 800. Fewer frames
// than the devices give: drawing takes the time.
TEST(simulated_flight, other_devices_are_tracked) {
  const struct {
    const char* name;
    double ate_of_path_max;
  } devices[] = {{"tumvi", 0.0021}, {"t265", 0.0016}, {"oakd", 0.0011}};
  for (const auto& device : devices) {
    SCOPED_TRACE(device.name);
    tools::SimOptions options;
    options.device = device.name;
    options.duration_s = 6;
    options.rate_hz = 20;
    options.blur = 1;
    const Replay run = replay(made(options, device.name));
    print(device.name, run);
    expect_tracked(run, device.ate_of_path_max);
  }
}

// Mei's model, drawn by its own formula, runs by the fisheye that comes nearest to it. Of the
// models that are fitted and not refused it is furthest off (docs/formats.md).
TEST(simulated_flight, a_lens_that_is_fitted_is_tracked) {
  const std::string file = scratch_folder("omni") + "/camchain-imucam.yaml";
  std::ofstream chain(file);
  for (const char* const y : {"0.05", "-0.05"}) {
    chain << (y[0] == '-' ? "cam1:\n" : "cam0:\n") << "  T_imu_cam: [0, 0, 1, 0.02, -1, 0, 0, " << y
          << ", 0, -1, 0, -0.03, 0, 0, 0, 1]\n  camera_model: omni\n"
             "  intrinsics: [3.320943260749003, 1197.12459604134, 1198.5870310209943,"
             " 308.64402245225887, 241.52711951080227]\n  distortion_model: radtan\n"
             "  distortion_coeffs: [0.6711385962510382, 12.74476648953634, -0.0007325429487165742,"
             " -0.0004169991326278497]\n  resolution: [640, 480]\n";
  }
  chain.close();
  tools::SimOptions options;
  options.device = file;
  options.duration_s = 5;
  options.rate_hz = 20;
  options.blur = 1;
  const Replay run = replay(made(options, "omni_drawn"));
  print("omni", run);
  expect_tracked(run, 0.0014);
}

// One App for the whole process: nothing of one recording may reach the next.
TEST(simulated_flight, a_run_forgets_the_one_before) {
  const std::string first = euroc_run().trajectory();
  (void)replay(simulated(SimulatedDevice::kIronsides));
  const Replay again = replay(simulated(SimulatedDevice::kEuroc));
  EXPECT_TRUE(first == again.trajectory()) << "a run depends on the one before";
  EXPECT_EQ(again.counter("starts"), 1u);
}

TEST(simulated_flight, every_counter_has_a_name_of_its_own) {
  std::set<std::string> names;
  for (const tools::Count& counter : euroc_run().log.counters)
    EXPECT_TRUE(names.insert(counter.name).second) << counter.name;
}

TEST(simulated_flight, three_cores_in_lockstep_give_the_bytes_of_one) {
  const Replay run =
      replay(simulated(SimulatedDevice::kEuroc), {3, {}, tools::Playback::kLockstep});
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_TRUE(run.trajectory() == euroc_run().trajectory()) << "cores change the trajectory";
  for (const char* name : {"keyframes", "adjustments", "points_stereo", "gate_chi2"}) {
    EXPECT_EQ(run.counter(name), euroc_run().counter(name)) << name;
  }
}

TEST(simulated_flight, three_cores_finish) {
  const Replay run = replay(simulated(SimulatedDevice::kEuroc), {3});
  print("euroc, three cores", run);
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_LE(run.ate_of_path(), 2 * kEuroc_max);
}

}  // namespace
}  // namespace pirvs::systems
