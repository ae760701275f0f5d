// What the world does to sensors: the stack goes on, counts it by name, and ends sanely. Each fault
// is put into the simulated EuRoC recording (118 frames, first pose ~0.8 s) as --fault does it, or
// in memory. What each is answered with: docs/faults.md.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/recordings.h"
#include "tests/replay.h"

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;
using tools::Recording;

constexpr double kAteOfPath_max = 0.01;  // after a fault that the stack bridges
constexpr double kSevere = 3;            // times as much after one that leaves it blind for a while

Recording recording() { return simulated(SimulatedDevice::kEuroc); }

size_t imu_index(const Recording& recording, double t_s) {
  const TimeNs t = recording.frames.front().t + from_seconds(t_s);
  size_t i = 0;
  while (recording.imu[i].t < t) ++i;
  return i;
}

void expect_bridged(const Replay& run) {
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_EQ(run.result.frames_lost, 0u);
  EXPECT_LE(run.ate_of_path(), kAteOfPath_max);
}

TEST(fault, truncated_and_undecodable_images) {
  const std::string folder = scratch_folder("broken");
  Recording broken = recording();
  std::string bytes(fs::file_size(broken.frames[40].image[0]), '\0');
  std::ifstream(broken.frames[40].image[0], std::ios::binary).read(&bytes[0], bytes.size());
  std::ofstream(folder + "/half.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  std::ofstream(folder + "/text.png", std::ios::binary) << "this is not an image";
  std::ofstream(folder + "/empty.png", std::ios::binary);
  cv::imwrite(folder + "/small.png", cv::Mat(48, 64, CV_8U, cv::Scalar(0)));
  broken.frames[40].image[0] = folder + "/half.png";
  broken.frames[45].image[1] = folder + "/text.png";
  broken.frames[50].image[0] = folder + "/empty.png";
  broken.frames[55].image[1] = folder + "/small.png";
  broken.frames[60].image[0] = broken.frames[60].image[1] = folder + "/nothing.png";
  const Replay run = replay(broken);
  print("broken images", run);
  expect_bridged(run);
  EXPECT_EQ(run.counter("images_cut_off"), 2u);
  EXPECT_EQ(run.counter("images_undecodable"), 1u);
  EXPECT_EQ(run.counter("images_of_wrong_size"), 1u);
  EXPECT_EQ(run.counter("images_missing"), 2u);
  EXPECT_EQ(run.counter("camera_missing"), 5u);
  EXPECT_EQ(run.result.frames_dropped, 0u) << "the one with neither goes on blind";
}

// A run with faults put in as by --fault, each of which must have happened.
Replay broken_by(const std::vector<std::string>& specs, int cores = 1) {
  Replay run = replay(simulated(SimulatedDevice::kEuroc), {cores, specs});
  print(specs.front().c_str(), run);
  for (const std::string& spec : specs) EXPECT_GT(run.applied(spec), 0u) << spec;
  for (const tools::TrajectoryPose& pose : run.result.trajectory.poses) {
    EXPECT_TRUE(pose.p_WB.allFinite() && pose.q_WB.allFinite());
  }
  return run;
}

bool was(const Replay& run, HealthState state) {
  for (const tools::HealthEvent& event : run.log.health) {
    if (event.state == state) return true;
  }
  return false;
}

// By how much the mean error of the last second differs from that of the second before `t`.
double drift_m(const Replay& run, TimeNs t) {
  Vec3 sum_m[2] = {Vec3::Zero(), Vec3::Zero()};
  int count[2] = {0, 0};
  const TimeNs ends[2] = {t, run.log.frames.back().t};
  for (const tools::EvalPose& pose : run.result.evaluation.matched) {
    for (int k = 0; k < 2; ++k) {
      if (pose.t > ends[k] || ends[k] - pose.t > from_seconds(1.0)) continue;
      sum_m[k] += pose.p_WB - pose.p_truth_WB;
      ++count[k];
    }
  }
  EXPECT_TRUE(count[0] > 0 && count[1] > 0);
  return (sum_m[0] / count[0] - sum_m[1] / count[1]).norm();
}

TEST(fault, a_camera_is_missing_for_a_while) {
  const Replay run = broken_by({"cam1:1.5-2.25", "cam0:3.5-4"});
  expect_bridged(run);
  EXPECT_EQ(run.counter("camera_missing"), 25u);
}

TEST(fault, a_tenth_of_the_frames_is_lost) {
  const Replay run = broken_by({"frames:0.1"});
  expect_bridged(run);
  EXPECT_EQ(run.result.frames_dropped, run.applied("frames:0.1"));
}

TEST(fault, imu_gaps) {
  for (const char* gap : {"imu:3-3.1", "imu:3-3.3", "imu:2.5-3.2"}) {
    const Replay run = broken_by({gap});
    expect_bridged(run);
    EXPECT_EQ(run.counter("imu_gap"), 1u);
    EXPECT_EQ(run.counter("stream_broken"), 0u);
  }
}

TEST(fault, a_long_imu_gap_starts_anew) {
  const Replay run = broken_by({"imu:2-3.2"});
  EXPECT_EQ(run.counter("stream_broken"), 1u);
  EXPECT_EQ(run.counter("starts"), 2u);
  EXPECT_TRUE(was(run, HealthState::kLost)) << "nobody must trust what was not measured";
  EXPECT_EQ(run.result.exit_status(), 0);
}

// The recording in real time, as a live IMU whose cable is out for two seconds.
TEST(fault, a_live_imu_falls_silent) {
  const Replay run = replay(recording(), {1, {"imu:2-4"}, tools::Playback::kRealTime});
  print("IMU silent", run);
  if (run.result.timing.back().mean > 25)
    GTEST_SKIP() << "no real time: half a frame period is gone";
  EXPECT_EQ(run.counter("imu_silent"), 1u);
  EXPECT_EQ(run.counter("stream_broken"), 1u);
  const tools::HealthEvent* told = nullptr;
  for (const tools::HealthEvent& event : run.log.health) {
    if (event.what == "the IMU is silent") told = &event;
  }
  ASSERT_NE(told, nullptr);
  EXPECT_EQ(told->state, HealthState::kLost) << "told before the IMU comes back";
  EXPECT_EQ(run.counter("starts"), 2u);
  EXPECT_EQ(run.result.exit_status(), 0) << run.result.verdict;
}

// Twenty times as many faults of the drivers as a bus has on a bad day.
TEST(fault, drivers_that_report_faults) {
  Recording faulty = recording();
  size_t imu = 0, frame = 0;
  const auto fault = [&](Sensor sensor, Status status) {
    OrderRow row;
    row.kind = ArrivalKind::kFault;
    row.sensor = sensor;
    row.status = status;
    faulty.order.push_back(row);
  };
  const auto spread = [&](size_t total) {  // as many of them as there are until this sample
    return imu * total / faulty.imu.size() - (imu - 1) * total / faulty.imu.size();
  };
  while (imu < faulty.imu.size() || frame < faulty.frames.size()) {
    OrderRow row;
    const bool is_frame = imu == faulty.imu.size() || (frame < faulty.frames.size() &&
                                                       faulty.frames[frame].t < faulty.imu[imu].t);
    row.kind = is_frame ? ArrivalKind::kFrame : ArrivalKind::kImu;
    ++(is_frame ? frame : imu);
    faulty.order.push_back(row);
    if (is_frame) continue;
    for (const Sensor sensor : {Sensor::kImu, Sensor::kCamera}) {
      for (size_t n = spread(2000); n > 0; --n) fault(sensor, Status::kBusFault);
      for (size_t n = spread(200); n > 0; --n) fault(sensor, Status::kTimeout);
    }
  }
  const Replay run = replay(faulty);
  print("2000 bus faults and 200 timeouts of each sensor", run);
  EXPECT_EQ(run.counter("imu_bus_fault"), 2000u);
  EXPECT_EQ(run.counter("imu_timeout"), 200u);
  EXPECT_EQ(run.counter("camera_bus_fault"), 2000u);
  EXPECT_EQ(run.counter("camera_timeout"), 200u);
  EXPECT_EQ(run.trajectory(), replay(recording()).trajectory());
  size_t told = 0;
  for (const tools::HealthEvent& event : run.log.health) {
    told += event.what == "the IMU's driver reports faults";
  }
  EXPECT_GE(told, 5u) << "about once a second";
}

TEST(fault, imu_samples_that_are_no_numbers) {
  const Replay run = broken_by({"nan:2.5", "nan:3-3.02"});
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_not_finite"), 5u);
}

TEST(fault, imu_samples_beyond_any_range) {
  for (const double value : {1e3, 1e300}) {
    Recording spike = recording();
    const size_t at = imu_index(spike, 2.5);
    spike.imu[at].w_B.x() = value;
    spike.imu[at + 1].f_B.z() = -value;
    const Replay run = replay(spike);
    print("IMU spike", run);
    expect_bridged(run);
    EXPECT_EQ(run.counter("imu_out_of_range"), 2u);
  }
}

TEST(fault, imu_spikes_within_range) {
  const Replay run = broken_by({"spike:2-4"});
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_spike"), run.applied("spike:2-4"));
}

TEST(fault, imu_at_full_scale) {
  const Replay run = broken_by({"saturate:2.5-2.7"});
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_saturated"), 40u);
}

TEST(fault, imu_stuck_at_one_value) {
  const Replay run = broken_by({"stuck:2.5-2.8"});
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_stuck"), 60u - 8u);
}

TEST(fault, images_that_stand_still_for_a_second) {
  const Replay run = broken_by({"frozen:3-4"});
  EXPECT_EQ(run.result.exit_status(), 0);
  EXPECT_EQ(run.counter("camera_frozen"), 40u);
  EXPECT_TRUE(was(run, HealthState::kDegraded)) << "health must say that it is blind";
  EXPECT_LE(run.ate_of_path(), kSevere * kAteOfPath_max);
}

TEST(fault, one_camera_is_late_by_a_frame) {
  for (const char* late : {"late:2.5", "late:2.5-3"}) {
    const Replay run = broken_by({late});
    expect_bridged(run);
    EXPECT_EQ(run.counter("camera_late"), run.applied(late));
  }
}

TEST(fault, stamps_go_back_once) {
  const Replay run = broken_by({"stamp:2.5"});
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_backwards"), 1u);
  EXPECT_EQ(run.counter("frame_backwards"), 1u);
  EXPECT_EQ(run.result.frames_dropped, 1u);
}

TEST(fault, stamps_that_repeat) {
  Recording again = recording();
  const size_t at = imu_index(again, 2.5);
  again.imu.insert(again.imu.begin() + at, again.imu[at]);            // twice
  again.imu.insert(again.imu.begin() + at + 50, again.imu[at + 20]);  // an old one
  again.frames.insert(again.frames.begin() + 60, again.frames[60]);
  again.frames.insert(again.frames.begin() + 80, again.frames[70]);
  const Replay run = replay(again);
  print("stamps not rising", run);
  expect_bridged(run);
  EXPECT_EQ(run.counter("imu_backwards"), 2u);
  EXPECT_EQ(run.counter("frame_backwards"), 2u);
  EXPECT_EQ(run.result.frames_dropped, 2u);
}

TEST(fault, the_clock_is_set) {
  for (const char* jump : {"clock:2.5x3600", "clock:2.5x-3600"}) {
    const Replay run = broken_by({jump});
    EXPECT_EQ(run.counter("stream_broken"), 1u);
    EXPECT_EQ(run.counter("starts"), 2u) << "time that passed is not known: a new start";
    EXPECT_TRUE(was(run, HealthState::kLost));
    EXPECT_GE(run.log.frames.size(), 105u);
  }
}

// When the clock of one sensor is set against the other's, stamps look as if items had been lost:
// until it is told apart nobody must act on the pose, then the right images go to the right
// samples.
TEST(fault, the_clock_of_one_sensor_is_set) {
  tools::SimOptions options;
  options.duration_s = 8;  // to tell may take until the body has turned enough, a start comes then
  options.blur = 2;
  const Recording flight = made(options, "clocks");
  for (const char* jump : {"clock-cam:2x0.5", "clock-cam:2x-0.5", "clock-imu:2x0.3",
                           "clock-imu:2x-0.3", "clock-imu:2x-0.7"}) {
    const Replay run = replay(flight, {1, {jump}});
    print(jump, run);
    const bool cameras = jump[6] == 'c';
    EXPECT_EQ(run.counter("camera_clock_set"), cameras ? 1u : 0u);
    EXPECT_EQ(run.counter("imu_clock_set"), cameras ? 0u : 1u);
    EXPECT_TRUE(was(run, HealthState::kLost));
    EXPECT_EQ(run.result.health_at_end, HealthState::kTracking);
    EXPECT_EQ(run.result.exit_status(), 0);
    const TimeNs set = run.log.frames.front().t + from_seconds(2.0);
    bool doubted = false;
    for (const FrameReport& frame : run.log.frames) {
      doubted |= frame.t >= set && frame.has_pose && frame.pose.trust.confidence <= 0.25f;
    }
    EXPECT_TRUE(doubted) << "whoever reads the confidence must have been warned";
    if (!cameras) continue;
    EXPECT_LT(drift_m(run, set), 0.1) << "back in the old map, at the right time";
  }
}

TEST(fault, frames_lost_in_a_row_are_no_clock_that_was_set) {
  Recording gap = recording();
  gap.frames.erase(gap.frames.begin() + 50, gap.frames.begin() + 60);
  const Replay run = replay(gap);
  print("half a second without frames", run);
  EXPECT_EQ(run.counter("camera_gap"), 1u);
  EXPECT_EQ(run.counter("camera_clock_set"), 0u);
  expect_bridged(run);
}

TEST(fault, flat_images_for_a_while) {
  for (const char* flat : {"black:3-4", "white:3-3.5"}) {
    const Replay run = broken_by({flat});
    EXPECT_EQ(run.result.exit_status(), 0);
    EXPECT_TRUE(was(run, HealthState::kDegraded)) << "health must say that it is blind";
    EXPECT_LE(run.ate_of_path(), kSevere * kAteOfPath_max);
  }
}

TEST(fault, exposure_jumps_by_a_factor_of_four) {
  for (const char* gain : {"gain:2.5-4x4", "gain:2.5x0.25"}) expect_bridged(broken_by({gain}));
}

TEST(fault, flat_images_from_the_start_give_no_pose) {
  for (const char* flat : {"black:0", "white:0"}) {
    const Replay run = broken_by({flat}, flat[0] == 'b' ? 1 : 2);
    EXPECT_EQ(run.status, Status::kBadData);
    EXPECT_EQ(run.result.exit_status(), 1);
    EXPECT_EQ(run.result.frames_before_start, run.result.frames_in);
  }
}

TEST(fault, sensors_that_end_early) {
  Recording deaf = recording();  // IMU ends in the middle
  deaf.imu.resize(imu_index(deaf, 3.0));
  const Replay deaf_run = replay(deaf);
  EXPECT_GT(deaf_run.counter("frame_without_imu"), 50u);
  Recording blind = recording();  // the cameras do
  blind.frames.resize(60);
  EXPECT_EQ(replay(blind).result.exit_status(), 0);
  Recording instant = recording();
  instant.frames.resize(1);
  EXPECT_EQ(replay(instant).result.exit_status(), 1);
  Recording late = recording();  // the IMU starts after some frames
  late.imu.erase(late.imu.begin(), late.imu.begin() + imu_index(late, 0.5));
  const Replay late_run = replay(late);
  EXPECT_EQ(late_run.result.exit_status(), 0);
  EXPECT_GE(late_run.counter("frame_before_imu"), 9u);
}

}  // namespace
}  // namespace pirvs::systems
