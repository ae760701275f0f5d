#include "tools/dataset/loose_tables.h"

#include <gtest/gtest.h>

#include "tools/dataset/input_error.h"
#include "tools/dataset/test_recording.h"

namespace pirvs::tools {
namespace {

constexpr StampRule kFrames = {kCameraRates, {}, {}};

std::vector<TimeNs> stamps_of(const std::string& text) {
  TestRecording disk;
  disk.write("frames.csv", text);
  const auto table = open_frame_stamps(disk.path("frames.csv"), kFrames);
  std::vector<TimeNs> out;
  while (table->next()) out.push_back(table->stamp().value_or(-1));
  return out;
}

TEST(loose_tables, a_column_that_counts_rows_is_passed_over) {
  const std::vector<TimeNs> wanted = {5'000'000'000, 5'050'000'000, 5'100'000'000};
  EXPECT_EQ(stamps_of("5.0\n5.05\n5.1\n"), wanted);
  EXPECT_EQ(stamps_of("0,5.0\n1,5.05\n2,5.1\n"), wanted);
  EXPECT_EQ(stamps_of("frame,time\n1,5.0\n2,5.05\n3,5.1\n"), wanted);
  EXPECT_EQ(stamps_of("5.0,0\n5.05,1\n5.1,2\n"), wanted);
  EXPECT_EQ(stamps_of("0 5000000000\n1 5050000000\n2 5100000000\n"), wanted);
}

TEST(loose_tables, reads_one_sensor) {
  TestRecording disk;
  disk.write("gyro.csv", "time,x,y,z\n1.01,4,5,6\n1.00,1,2,3\n1.02,nan,0,0\n1.03,7,8,9\n");
  TextTable table(disk.path("gyro.csv"), "gyro samples", {kImuRates, {}, {}});
  InputLog log;
  const auto samples = read_triples(table, &ImuSample::w_B, "gyro.csv", log);
  ASSERT_EQ(samples.size(), 3u);
  EXPECT_EQ(samples[0].t, 1'000'000'000);
  EXPECT_EQ(samples[1].w_B, Vec3(4, 5, 6));
  EXPECT_EQ(log.counted("imu_samples_not_finite"), 1u);
  EXPECT_EQ(log.counted("imu_rows_out_of_order"), 1u);
  disk.write("short.csv", "1.00,1,2\n1.01,1,2\n1.02,1,2\n");
  TextTable cut(disk.path("short.csv"), "gyro samples", {kImuRates, {}, {}});
  EXPECT_THROW(read_triples(cut, &ImuSample::w_B, "short.csv", log), InputError);
}

TEST(loose_tables, gravity_tells_the_accelerometer) {
  InputLog log;
  const ImuSample right = {0, Vec3(0.1, 0, 0), Vec3(0, 0, 9.8)};
  std::vector<ImuSample> samples = {right, right, right};
  put_gyro_first(samples, log);
  EXPECT_EQ(samples[1].f_B, right.f_B);
  EXPECT_TRUE(log.notes.empty());
  for (ImuSample& sample : samples) std::swap(sample.w_B, sample.f_B);
  put_gyro_first(samples, log);
  EXPECT_EQ(samples[1].f_B, right.f_B);
  EXPECT_EQ(log.notes.size(), 1u);
}

}  // namespace
}  // namespace pirvs::tools
