#include "tools/dataset/gnss_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/math/geodesy.h"
#include "core/math/trig.h"
#include "modules/gnss/nmea_sentence_test.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/recording.h"
#include "tools/dataset/test_recording.h"

namespace pirvs::tools {
namespace {

using testing::sentence;

constexpr double kDeg = kPi / 180;
constexpr const char* kHeading =
    "#timestamp [ns],latitude [deg],longitude [deg],height [m],v_north [m/s],v_east [m/s],"
    "v_down [m/s],sigma_horizontal [m],sigma_vertical [m],sigma_velocity [m/s],fix\n";

class File {
 public:
  File(const std::string& name, const std::string& text)
      : path_((std::filesystem::temp_directory_path() /
               ("pirvs_gnss_" + std::to_string(getpid()) + name))
                  .string()) {
    std::ofstream(path_, std::ios::binary) << text;
  }
  ~File() { std::filesystem::remove(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

std::vector<GnssFix> read(const std::string& path) {
  InputLog log;
  return read_gnss(path, gnss_format(path), log);
}

TEST(gnss_file, a_table_is_read_as_it_says) {
  const File file("a.csv", std::string(kHeading) +
                               "1600000000013000000,47.3977,8.5456,488.0,0.1,0.2,-0.3,0.01,0.015,"
                               "0.03,fixed\n"
                               "1600000001013000000,47.3978,8.5457,489.0,,,,1.5,2.5,,3d\n"
                               "1600000002013000000,47.3978,8.5457,489.0,1,2,,1.5,2.5,0.1,float\n");
  const auto fixes = read(file.path());
  ASSERT_EQ(fixes.size(), 3u);
  EXPECT_EQ(fixes[0].t, 1600000000013000000);
  EXPECT_EQ(fixes[0].type, GnssFixType::kFixed);
  EXPECT_EQ(fixes[0].v_ned, Vec3(0.1, 0.2, -0.3));
  EXPECT_EQ(fixes[0].sigma_velocity_m_s, 0.03);
  EXPECT_FALSE(fixes[1].has_velocity);
  EXPECT_EQ(fixes[1].sigma_vertical_m, 2.5);
  EXPECT_TRUE(fixes[2].has_velocity);
  EXPECT_TRUE(std::isnan(fixes[2].v_ned.z()));
}

TEST(gnss_file, what_is_no_table_is_refused_with_its_line) {
  for (const char* row : {"1600000000013000000,47.3,8.5,488,0,0,0,1,1,1,best\n",
                          "1600000000013000000,47.3,x,488,0,0,0,1,1,1,3d\n",
                          "1600000000013000000,nan,8.5,488,0,0,0,1,1,1,3d\n",
                          "1600000000013000000,47.3,8.5,488,0,0,0,1,1\n"}) {
    const File file("b.csv", std::string(kHeading) + row);
    try {
      (void)read(file.path());
      ADD_FAILURE() << row;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("line 2"), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW((void)read("/nowhere/gnss.ubx"), InputError);
  EXPECT_THROW((void)read(File("c.nmea", "nothing").path()), InputError);
}

TEST(gnss_file, rows_that_go_back_or_are_cut_off_are_counted) {
  const std::string row = "1600000000013000000,47.3,8.5,488,,,,1,1,,3d\n";
  const File file("d.csv", kHeading + row + row + "1600000001013000000,47.3,8");
  InputLog log;
  EXPECT_EQ(read_gnss(file.path(), GnssFormat::kTable, log).size(), 1u);
  EXPECT_EQ(log.counted("gnss_stamps_not_rising"), 1u);
  EXPECT_EQ(log.counted("gnss_rows_truncated"), 1u);
}

TEST(gnss_file, a_recording_has_its_fixes_and_antenna) {
  const TestRecording recording;
  recording.write("gnss0/data.csv", std::string(kHeading) +
                                        "1500000000050000000,47.3,8.5,488,,,,1,1,,3d\n"
                                        "1500000000450000000,47.3,8.5,488,,,,1,1,,3d\n");
  recording.write("gnss0/sensor.yaml",
                  "T_BS:\n  data: [1,0,0,0.1, 0,1,0,0.2, 0,0,1,0.3, 0,0,0,1]\nlatency: 0.1\n"
                  "time_offset: -0.01\ntruth_world: [47, 8, 400, 30]\n");
  const Recording opened = open_recording(recording.folder(), {});
  EXPECT_EQ(opened.gnss.size(), 2u);
  EXPECT_EQ(opened.calibration.gnss.p_BA, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(opened.calibration.gnss.time_offset_ns, -10'000'000);
  EXPECT_EQ(opened.gnss_sensor.latency_ns, 100'000'000);
  EXPECT_TRUE(opened.gnss_sensor.has_truth);
  RecordingOptions part;
  part.duration_s = 0.2;
  EXPECT_EQ(open_recording(recording.folder(), part).gnss.size(), 1u);
  recording.write("gnss0/sensor.yaml", "latency: never\n");
  EXPECT_THROW((void)open_recording(recording.folder(), {}), InputError);
}

std::string angle(double deg, int digits, const char* letters) {
  const double size = std::abs(deg);
  const int whole = int(size);
  char text[40];
  std::snprintf(text, sizeof text, "%0*d%010.7f,%c", digits, whole, 60 * (size - whole),
                letters[deg < 0 ? 1 : 0]);
  return text;
}

// The same fixes as a receiver of NMEA would tell them.
std::string as_nmea(const std::vector<GnssFix>& fixes) {
  std::string out;
  for (const GnssFix& fix : fixes) {
    constexpr TimeNs kDay = 86400'000'000'000;
    const TimeNs of_day = fix.t % kDay;
    const int seconds = int(of_day / 1'000'000'000);
    char text[160], time[40];
    std::snprintf(time, sizeof time, "%02d%02d%02d.%09d", seconds / 3600, seconds / 60 % 60,
                  seconds % 60, int(of_day % 1'000'000'000));
    const int quality = fix.type == GnssFixType::kFixed   ? 4
                        : fix.type == GnssFixType::kFloat ? 5
                                                          : 1;
    std::snprintf(text, sizeof text, ",%d,25,0.5,%.4f,M,-20.5000,M,,", quality,
                  fix.height_m + 20.5);
    const std::string place =
        angle(fix.latitude_deg, 2, "NS") + "," + angle(fix.longitude_deg, 3, "EW");
    out += sentence("GNGGA," + std::string(time) + "," + place + text);
    const double speed = fix.v_ned.head<2>().norm();
    const double course = std::atan2(fix.v_ned.y(), fix.v_ned.x()) / kDeg;
    std::snprintf(text, sizeof text, ",%.6f,%.6f,280825,,,R", speed * 3600 / 1852,
                  course < 0 ? course + 360 : course);
    out += sentence("GNRMC," + std::string(time) + ",A," + place + text);
    const double s = fix.sigma_horizontal_m;
    std::snprintf(text, sizeof text, ",1.0,,,,%.6f,%.6f,%.6f", s, s, fix.sigma_vertical_m);
    out += sentence("GNGST," + std::string(time) + text);
  }
  return out;
}

Vec3 apart_m(const GnssFix& a, const GnssFix& b) {
  const LocalFrame frame({b.latitude_deg * kDeg, b.longitude_deg * kDeg, b.height_m});
  return frame.to_local({a.latitude_deg * kDeg, a.longitude_deg * kDeg, a.height_m});
}

std::string walk() {
  const char* const root = std::getenv("PIRVS_DATA");
  return std::string(root ? root : "../shared/data") + "/gnss_walk";
}

TEST(gnss_file, a_walk_is_where_its_rtk_solution_says) {
  if (!std::filesystem::exists(walk())) {
    GTEST_SKIP() << "no recording at " << walk() << ": set PIRVS_DATA";
  }
  const auto fixes = read(walk() + "/gnss.ubx"), truth = read(walk() + "/rtk.pos");
  ASSERT_EQ(fixes.size(), 536u);
  std::vector<double> horizontal;
  size_t j = 0;
  for (const GnssFix& rtk : truth) {
    if (rtk.type != GnssFixType::kFixed) continue;
    while (j + 1 < fixes.size() && fixes[j].t < rtk.t - 1'000'000) ++j;
    if (std::abs(fixes[j].t - rtk.t) > 1'000'000) continue;
    horizontal.push_back(apart_m(fixes[j], rtk).head<2>().norm());
  }
  ASSERT_GT(horizontal.size(), 300u);
  std::sort(horizontal.begin(), horizontal.end());
  const double median = horizontal[horizontal.size() / 2];
  const double p95 = horizontal[horizontal.size() * 95 / 100];
  std::printf("%zu fixes against RTK: horizontal median %.4f m, p95 %.4f m\n", horizontal.size(),
              median, p95);
  EXPECT_LT(median, 0.02);
  EXPECT_LT(p95, 0.05);
}

TEST(gnss_file, the_walk_in_nmea_is_the_same_walk) {
  if (!std::filesystem::exists(walk())) {
    GTEST_SKIP() << "no recording at " << walk() << ": set PIRVS_DATA";
  }
  const auto fixes = read(walk() + "/gnss.ubx");
  const File file("walk.nmea", as_nmea(fixes));
  const auto again = read(file.path());
  ASSERT_EQ(again.size(), fixes.size());
  for (size_t i = 0; i < fixes.size(); ++i) {
    EXPECT_EQ(again[i].t, fixes[i].t);
    EXPECT_EQ(again[i].type, fixes[i].type);
    EXPECT_LT(apart_m(again[i], fixes[i]).norm(), 2e-3) << i;
    EXPECT_LT((again[i].v_ned - fixes[i].v_ned).head<2>().norm(), 1e-5) << i;
    EXPECT_NEAR(again[i].sigma_horizontal_m, fixes[i].sigma_horizontal_m, 1e-6);
    EXPECT_NEAR(again[i].sigma_vertical_m, fixes[i].sigma_vertical_m, 1e-6);
  }
}

}  // namespace
}  // namespace pirvs::tools
