#include "tools/dataset/wheel_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/test_recording.h"

namespace pirvs::tools {
namespace {

constexpr const char* kPlace =
    "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, -0.2, 0, 1, 0, 0, 0, 0, 1, -0.4, 0, 0, 0, 1]\n";
constexpr const char* kTable = "wheel0/data.csv";
constexpr const char* kSensor = "wheel0/sensor.yaml";

TEST(wheel_file, a_table_is_read_and_what_is_wrong_in_it_counted) {
  const TestRecording disk;
  disk.write(kTable,
             "#timestamp [ns],left [m/s],right [m/s]\n1600000000000000000,0.5,0.6\n"
             "1600000000020000000,nan,0.6\n1600000000040000000,0.7,0.8\n"
             "1600000000040000000,0.9,1.0\n16000000000600");
  InputLog log;
  const auto samples = read_wheels(disk.path(kTable), WheelKind::kLeftRight, log);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[1].t, 1600000000040000000);
  EXPECT_EQ(samples[1].value[1], 0.8);
  EXPECT_EQ(log.rejected.size(), 3u);
  disk.write(kTable, "#timestamp [ns],left [m/s],right [m/s]\n1600000000000000000,x,1\n1,2,3\n");
  EXPECT_THROW(read_wheels(disk.path(kTable), WheelKind::kLeftRight, log), InputError);
}

TEST(wheel_file, a_sensor_says_what_its_kind_needs) {
  const TestRecording disk;
  disk.write(kSensor, std::string("kind: ticks\nradius: 0.1\nticks_per_turn: 1000\n"
                                  "track: 0.4\ntime_offset: -0.01\n") +
                          kPlace);
  const WheelSensor sensor = read_wheel_sensor(disk.path(kSensor));
  EXPECT_EQ(sensor.kind, WheelKind::kTicks);
  EXPECT_TRUE(sensor.calibration.known);
  EXPECT_NEAR(sensor.calibration.tick_m, 2 * M_PI * 0.1 / 1000, 1e-12);
  EXPECT_EQ(sensor.calibration.T_BV.p, Vec3(-0.2, 0, -0.4));
  EXPECT_EQ(sensor.calibration.time_offset_ns, -10'000'000);
  for (const char* text : {"kind: tracks\n", "kind: ticks\n", "kind: steering\ntrack: 1\n",
                           "kind: twist\ntrack: -1\n", "kind: twist\ntime_offset: 99\n"}) {
    disk.write(kSensor, text + std::string(kPlace));
    EXPECT_THROW(read_wheel_sensor(disk.path(kSensor)), InputError) << text;
  }
  disk.write(kSensor, "kind: twist\n");
  EXPECT_THROW(read_wheel_sensor(disk.path(kSensor)), InputError) << "no T_BS";
}

}  // namespace
}  // namespace pirvs::tools
