#include "tools/run/trace_file.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bsp/api/clock.h"
#include "core/trace/trace.h"

namespace pirvs::tools {
namespace {

TEST(trace_file, holds_each_scope_and_names_its_lane) {
  trace_start(bsp::now);
  for (int i = 0; i < 2; ++i) {
    PIRVS_TRACE("probe");
  }
  trace_start(nullptr);  // off; what was seen stays only until the next start
  trace_start(bsp::now);
  { PIRVS_TRACE("other"); }
  const nlohmann::json trace = nlohmann::json::parse(trace_json());
  trace_start(nullptr);
  int scopes = 0, lanes = 0;
  for (const nlohmann::json& event : trace["traceEvents"]) {
    if (event["ph"] == "X") {
      ++scopes;
      EXPECT_EQ(event["name"], "other");
      EXPECT_GE(event["dur"].get<double>(), 0.0);
    } else {
      ++lanes;
      EXPECT_EQ(event["args"]["name"], "other");
    }
  }
  EXPECT_EQ(scopes, 1);
  EXPECT_EQ(lanes, 1);
}

}  // namespace
}  // namespace pirvs::tools
