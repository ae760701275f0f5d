// The whole stack on simulated flights of both devices, with exact truth.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

constexpr double kAteOfPath_max = 0.005;

// Shared: a run takes seconds.
const Replay& euroc_run() {
  static const Replay run = replay(simulated(SimulatedDevice::kEuroc));
  return run;
}

void expect_tracked(const Replay& run) {
  EXPECT_EQ(run.status, Status::kOk);
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_LE(run.first_pose_s(), 2.0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_EQ(run.result.frames_dropped, 0u);
  expect_no_failures(run);
  ASSERT_TRUE(run.result.evaluation.ok);
  EXPECT_LE(run.ate_of_path(), kAteOfPath_max);
}

TEST(simulated_flight, euroc_is_tracked_to_half_a_percent) {
  print("euroc", euroc_run());
  expect_tracked(euroc_run());
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

TEST(simulated_flight, ironsides_fisheyes_are_tracked_to_half_a_percent) {
  const Replay run = replay(simulated(SimulatedDevice::kIronsides));
  print("ironsides", run);
  expect_tracked(run);
}

// Other sizes and lenses with the same parameters: 512 x 512, 848 x 800, 1280 x 800. Fewer frames
// than the devices give: drawing takes the time.
TEST(simulated_flight, other_devices_are_tracked_to_half_a_percent) {
  for (const char* device : {"tumvi", "t265", "oakd"}) {
    SCOPED_TRACE(device);
    tools::SimOptions options;
    options.device = device;
    options.duration_s = 6;
    options.rate_hz = 20;
    options.blur = 1;
    const Replay run = replay(made(options, device));
    print(device, run);
    expect_tracked(run);
  }
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
  EXPECT_LE(run.ate_of_path(), 2 * kAteOfPath_max);
}

}  // namespace
}  // namespace pirvs::systems
