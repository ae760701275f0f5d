#include "modules/app/app_params.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>
#include <string>

namespace pirvs {
namespace {

bool same(const AppParams& a, const AppParams& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST(AppParams, AreSetByNameWithAGroupWhereSeveralHaveIt) {
  AppParams params;
  EXPECT_TRUE(set_parameter(params, "lk_levels", 3.0f).ok());
  EXPECT_EQ(params.frontend.lk_levels, 3);
  EXPECT_TRUE(set_parameter(params, "mapping.sigma_px", "0.7").ok());
  EXPECT_EQ(params.mapping.sigma_px, 0.7f);
  EXPECT_EQ(params.tracking.filter.sigma_px, FilterParams{}.sigma_px);
}

TEST(AppParams, StayWhenAValueIsRefused) {
  const struct {
    const char *name, *text;
    ParamStatus status;
  } refused[] = {
      {"sigma_px", "1", ParamStatus::kAmbiguous},
      {"nothing", "1", ParamStatus::kNotFound},
      {"filter.lk_levels", "3", ParamStatus::kNotFound},
      {"", "3", ParamStatus::kNotFound},
      {"frontend.", "3", ParamStatus::kNotFound},
      {"mapping.window", "3.9", ParamStatus::kNotWhole},
      {"mapping.window", "2", ParamStatus::kOutOfRange},
      {"mapping.window", "1e40", ParamStatus::kOutOfRange},
      {"mapping.window", "ten", ParamStatus::kNotANumber},
      {"mapping.window", "nan", ParamStatus::kNotANumber},
      {"mapping.window", "", ParamStatus::kNotANumber},
  };
  for (const auto& refused : refused) {
    AppParams params;
    const ParamAnswer answer = set_parameter(params, refused.name, refused.text);
    EXPECT_EQ(answer.status, refused.status) << refused.name << "=" << refused.text;
    EXPECT_TRUE(same(params, AppParams{})) << refused.name << "=" << refused.text;
  }
  AppParams params;
  EXPECT_EQ(set_parameter(params, "mapping.window", NAN).status, ParamStatus::kOutOfRange);
  EXPECT_EQ(set_parameter(params, "mapping.window", 99.0f).max, 12.0f);
}

// Each name leads to a field of its own, and takes both ends of its range.
TEST(AppParams, EveryRowCanBeSetByItsFullName) {
  std::set<std::string> names;
  const AppParams defaults;
  for_each_group(defaults, [&](const char* group, const auto& values, const auto& rows) {
    for (const auto& row : rows) {
      const std::string name = std::string(group) + "." + row.name;
      EXPECT_TRUE(names.insert(name).second) << name;
      EXPECT_GT(std::strlen(row.meaning), 0u) << name;
      for (const float value : {row.min, row.max}) {
        AppParams params;
        EXPECT_TRUE(set_parameter(params, name, value).ok()) << name;
        EXPECT_TRUE(set_parameter(params, name, values.*row.field).ok()) << name;
        EXPECT_TRUE(same(params, defaults)) << name;
      }
    }
  });
  EXPECT_EQ(names.size(), parameter_count());
}

}  // namespace
}  // namespace pirvs
