#include "modules/gnss/nmea.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "modules/gnss/nmea_sentence_test.h"

namespace pirvs {
namespace {

using testing::sentence;

std::string gga(const std::string& time, const std::string& rest =
                                             "4005.8014960,N,10508.8299900,W,4,25,0.5,1601.400,M,"
                                             "-21.352,M,1.0,0000") {
  return sentence("GNGGA," + time + "," + rest);
}
std::string rmc(const std::string& time, const std::string& date = "280825") {
  return sentence("GNRMC," + time + ",A,4005.80,N,10508.83,W,1.9438445,45.0," + date + ",,,R");
}
std::string vtg() { return sentence("GNVTG,90.0,T,,M,1.944,N,7.2,K,D"); }
std::string gst(const std::string& time) {
  return sentence("GNGST," + time + ",1.1,0.5,0.4,12.0,0.3,0.4,0.8");
}

std::vector<ReceiverFix> read(NmeaReader& reader, const std::string& text) {
  std::vector<ReceiverFix> out;
  ReceiverFix fix;
  for (const char c : text) {
    if (reader.take(uint8_t(c), fix)) out.push_back(fix);
  }
  return out;
}

TEST(nmea, sentences_of_one_time_are_one_fix) {
  NmeaReader reader;
  const std::string first = gga("173021.75") + rmc("173021.75") + vtg() + gst("173021.75");
  EXPECT_EQ(read(reader, first).size(), 0u);  // nobody knows yet that this was all
  const auto fixes = read(reader, gga("173022.00"));
  ASSERT_EQ(fixes.size(), 1u);
  const GnssFix& fix = fixes[0].fix;
  EXPECT_EQ(fix.type, GnssFixType::kFixed);
  EXPECT_NEAR(fix.latitude_deg, 40.0966916, 1e-9);
  EXPECT_NEAR(fix.longitude_deg, -105.1471665, 1e-9);
  EXPECT_NEAR(fix.height_m, 1580.048, 1e-9);
  EXPECT_NEAR(fix.sigma_horizontal_m, std::sqrt(0.125), 1e-9);
  EXPECT_NEAR(fix.sigma_vertical_m, 0.8, 1e-9);
  ASSERT_TRUE(fix.has_velocity);
  EXPECT_NEAR(fix.v_ned.x(), 0.0, 1e-9);  // VTG came last: 7.2 km/h to the east
  EXPECT_NEAR(fix.v_ned.y(), 2.0, 1e-9);
  EXPECT_TRUE(std::isnan(fix.v_ned.z()));
  EXPECT_TRUE(fixes[0].has_time);
  EXPECT_EQ(fixes[0].t_utc, 1756402221'750000000);
}

TEST(nmea, the_sentence_that_came_last_closes_the_next_fix) {
  NmeaReader reader;
  (void)read(reader, gga("173021.75") + rmc("173021.75") + gst("173021.75"));
  EXPECT_EQ(read(reader, gga("173022.00")).size(), 1u);
  EXPECT_EQ(read(reader, rmc("173022.00")).size(), 0u);
  EXPECT_EQ(read(reader, gst("173022.00")).size(), 1u);
  EXPECT_EQ(read(reader, gga("173022.25") + rmc("173022.25")).size(), 0u);
  // GST is lost: the next time tells.
  EXPECT_EQ(read(reader, gga("173022.50")).size(), 1u);
  ReceiverFix rest;
  EXPECT_TRUE(reader.flush(rest));
  EXPECT_FALSE(reader.flush(rest));
}

TEST(nmea, a_receiver_of_gga_alone) {
  NmeaReader reader;
  std::string text;
  for (int i = 0; i < 10; ++i) text += gga("17302" + std::to_string(i) + ".00");
  const auto fixes = read(reader, text);
  ASSERT_EQ(fixes.size(), 10u) << "each with its own sentence, but the first";
  EXPECT_TRUE(fixes[0].overdue);
  EXPECT_FALSE(fixes[1].overdue);
  EXPECT_FALSE(fixes[9].has_time) << "GGA has no date";
  EXPECT_FALSE(fixes[9].fix.has_velocity);
  ReceiverFix rest;
  EXPECT_FALSE(reader.flush(rest));
}

TEST(nmea, midnight_comes_before_its_date) {
  NmeaReader reader;
  const auto fixes = read(reader, gga("235959.50") + rmc("235959.50") + gga("000000.00"));
  ASSERT_EQ(fixes.size(), 1u);
  ReceiverFix next;
  ASSERT_TRUE(reader.flush(next));
  EXPECT_EQ(next.t_utc - fixes[0].t_utc, 500'000'000);
}

TEST(nmea, no_fix_is_told_as_none) {
  NmeaReader reader;
  const std::string text = gga("173021.75", ",,,,0,00,99.99,,M,,M,,") + gga("173022.00");
  const auto fixes = read(reader, text);
  ASSERT_EQ(fixes.size(), 2u);
  EXPECT_EQ(fixes[0].fix.type, GnssFixType::kNone);
}

TEST(nmea, without_the_geoid_there_is_no_height) {
  NmeaReader reader;
  const std::string rest = "4005.80,N,10508.83,W,1,08,0.9,1601.4,M,,M,,";
  const auto fixes = read(reader, gga("173021.75", rest) + gga("173022.00"));
  ASSERT_EQ(fixes.size(), 2u);
  EXPECT_EQ(fixes[0].fix.type, GnssFixType::k2d);
}

TEST(nmea, wrong_fields_say_nothing) {
  for (const char* rest : {"4060.00,N,10508.83,W,1,08,0.9,1.0,M,2.0,M,,",    // 60 minutes
                           "9100.00,N,10508.83,W,1,08,0.9,1.0,M,2.0,M,,",    // 91 degrees
                           "4005.80,X,10508.83,W,1,08,0.9,1.0,M,2.0,M,,",    // no such half
                           "4005.80,N,10508.83,W,9,08,0.9,1.0,M,2.0,M,,",    // no such quality
                           "4005.80,N,10508.83,W,1,08,0.9,1e999,M,2.0,M,,",  // infinite
                           "-405.80,N,10508.83,W,1,08,0.9,1.0,M,2.0,M,,",    // a sign
                           "4005.80,N,10508.83,W,1,08,0.9"}) {               // too few
    NmeaReader reader;
    EXPECT_EQ(read(reader, gga("173021.75", rest) + gga("173022.00")).size(), 0u) << rest;
    EXPECT_EQ(reader.counters().fields_wrong, 1u) << rest;
  }
  for (const char* time : {"253021.75", "17302", "173021x75", "1730-1.75"}) {
    NmeaReader reader;
    EXPECT_EQ(read(reader, gga(time)).size(), 0u);
    EXPECT_EQ(reader.counters().fields_wrong, 1u) << time;
  }
}

TEST(nmea, garbage_is_counted_and_costs_no_sentence) {
  std::mt19937 random(5);
  NmeaReader reader;
  size_t garbage = 0, fixes = 0;
  for (int i = 0; i < 100; ++i) {
    std::string noise;
    for (size_t k = random() % 300; k > 0; --k) noise += char(random() % 256);
    noise += "$GNGGA,1730";  // cut off
    for (size_t at = noise.find('*'); at != std::string::npos; at = noise.find('*'))
      noise[at] = '+';
    garbage += noise.size();
    char time[32];
    std::snprintf(time, sizeof time, "%02d%02d%02d.00", i / 60, i % 60, 0);
    const std::string good = gga(time);
    garbage += 1;  // the line feed behind the carriage return
    fixes += read(reader, noise + good).size();
  }
  EXPECT_EQ(fixes, 100u);
  EXPECT_EQ(reader.counters().sentences, 100u);
  EXPECT_EQ(reader.counters().bytes_outside, garbage);
}

TEST(nmea, a_wrong_character_is_no_fix) {
  const std::string good = gga("173021.75");
  for (size_t i = 0; i < good.size() - 2; ++i) {
    NmeaReader reader;
    std::string wrong = good;
    wrong[i] = wrong[i] == '1' ? '2' : '1';
    (void)read(reader, wrong);
    ReceiverFix fix;
    EXPECT_FALSE(reader.flush(fix)) << i;
  }
}

}  // namespace
}  // namespace pirvs
