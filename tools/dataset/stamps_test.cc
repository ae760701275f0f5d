#include "tools/dataset/stamps.h"

#include <gtest/gtest.h>

#include "tools/dataset/input_error.h"
#include "tools/dataset/test_recording.h"
#include "tools/dataset/text_table.h"

namespace pirvs::tools {
namespace {

TEST(stamps, every_form_is_exact) {
  constexpr TimeNs t = 1'403'636'579'763'555'584;
  const std::pair<const char*, StampUnit> forms[] = {
      {"1403636579763555584", StampUnit::kNanoseconds},
      {"1403636579763555584.0", StampUnit::kNanoseconds},
      {"1.403636579763555584e+18", StampUnit::kNanoseconds},
      {"1403636579763555.584", StampUnit::kMicroseconds},
      {"1403636579763.555584", StampUnit::kMilliseconds},
      {"1403636579.763555584", StampUnit::kSeconds},
      {"1403636579.7635555849999999999999999999999999999", StampUnit::kSeconds},
      {"1.403636579763555584E9", StampUnit::kSeconds},
      {"+0001403636579.763555584", StampUnit::kSeconds}};
  for (const auto& [text, unit] : forms) EXPECT_EQ(stamp_ns(text, unit), t) << text;
  EXPECT_EQ(stamp_ns("-0.25", StampUnit::kSeconds), -250'000'000);
  EXPECT_EQ(stamp_ns("1e-9", StampUnit::kSeconds), 1);
  EXPECT_EQ(stamp_ns("0", StampUnit::kMilliseconds), 0);
  for (const char* text : {"", ".", "-", "1e", "e5", "12a", "1.2.3", "1403636579763555584000",
                           "1e30", "1e99999999999", "nan"}) {
    EXPECT_FALSE(stamp_ns(text, StampUnit::kSeconds).has_value()) << text;
  }
}

// Rows at `hz`, beginning at `first_s`, written in units of which a second has `per_second`.
StampUnit unit_of(double first_s, double hz, double per_second, const StampRule& rule,
                  const char* heading = "") {
  std::vector<double> stamps;
  for (int i = 0; i < 50; ++i) stamps.push_back((first_s + i / hz) * per_second);
  return unit_of_stamps(stamps, false, heading, rule);
}

TEST(stamps, the_rate_tells_the_unit) {
  const std::pair<StampUnit, double> units[] = {{StampUnit::kNanoseconds, 1e9},
                                                {StampUnit::kMicroseconds, 1e6},
                                                {StampUnit::kMilliseconds, 1e3},
                                                {StampUnit::kSeconds, 1}};
  for (const auto& [unit, per_second] : units) {
    for (const double first_s : {0.0, 91273.2, 1.4e9}) {
      for (const double hz : {4.0, 20.0, 60.0, 200.0}) {
        EXPECT_EQ(unit_of(first_s, hz, per_second, {kCameraRates, {}, {}}, "#timestamp [ns]"), unit)
            << first_s << " " << hz << " " << per_second;
      }
      for (const double hz : {50.0, 200.0, 1000.0, 4000.0}) {
        if (unit == StampUnit::kSeconds && first_s > 1e9 && hz > 1000) continue;
        EXPECT_EQ(unit_of(first_s, hz, per_second, {kImuRates, {}, {}}), unit)
            << first_s << " " << hz << " " << per_second;
      }
    }
  }
}

// 1.2 Hz in ms could be 1200 Hz in us: the date, then the other tables, then the heading decide.
TEST(stamps, near_an_end_of_the_rates_others_decide) {
  const StampRule alone = {kCameraRates, {}, {}};
  EXPECT_EQ(unit_of(5, 1.2, 1e3, alone), StampUnit::kUnknown);
  EXPECT_EQ(unit_of(1.4e9, 1.2, 1e3, alone), StampUnit::kMilliseconds);
  EXPECT_EQ(unit_of(5, 1.2, 1e3, {kCameraRates, {}, StampUnit::kMilliseconds}),
            StampUnit::kMilliseconds);
  EXPECT_EQ(unit_of(5, 1.2, 1e3, alone, "t (ms)"), StampUnit::kMilliseconds);
  EXPECT_EQ(unit_of(5, 1.2, 1e3, {kCameraRates, StampUnit::kMicroseconds, {}}),
            StampUnit::kMicroseconds);
}

TEST(stamps, rows_in_batches_or_twice_or_wild_change_nothing) {
  std::vector<double> stamps;
  for (int i = 0; i < 400; ++i) stamps.push_back(1e6 * (i / 20) * 100 / 1e3);  // 20 at a time
  stamps.push_back(9e15);
  EXPECT_EQ(unit_of_stamps(stamps, false, "", {kImuRates, {}, {}}), StampUnit::kMicroseconds);
}

TEST(stamps, a_table_without_a_clue_asks) {
  const TestRecording disk;
  disk.write("t.csv", "5000,1\n20000,2\n35000,3\n");
  TextTable table(disk.path("t.csv"), "fixes");
  ASSERT_TRUE(table.next());
  EXPECT_THROW((void)table.stamp(), InputError);
}

}  // namespace
}  // namespace pirvs::tools
