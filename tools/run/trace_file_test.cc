#include "tools/run/trace_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bsp/api/clock.h"
#include "core/trace/trace.h"
#include "tools/dataset/input_error.h"

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
  const std::string path = (std::filesystem::temp_directory_path() / "pirvs_trace.json").string();
  write_trace(path);
  trace_start(nullptr);
  std::ifstream file(path);
  const nlohmann::json trace = nlohmann::json::parse(file);
  std::filesystem::remove(path);
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

TEST(trace_file, a_full_disk_is_an_error) { EXPECT_THROW(write_trace("/dev/full"), InputError); }

}  // namespace
}  // namespace pirvs::tools
