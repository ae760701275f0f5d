// `pirvs view` in a browser: headless Chromium, driven by browser.cjs with real clicks.
// In      PIRVS_BUILD (default build): host/pirvs, view/view.html, and view-test/node_modules that
//         make fetches. PIRVS_CHROMIUM: another browser. The clip, else a simulated recording.
// Cost    40 s, most of it in real time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string build_folder() {
  const char* const folder = std::getenv("PIRVS_BUILD");
  return folder != nullptr ? folder : "build";
}

// The last line of what it says.
json looked_at(const std::string& what, const std::string& source, const std::string& folder) {
  const char* const picture = std::getenv("PIRVS_PICTURES");
  const std::string command = "NODE_PATH=" + build_folder() +
                              "/view-test/node_modules node tests/view/browser.cjs " +
                              build_folder() + "/host/pirvs " + what + " " + source + " " + folder +
                              (picture != nullptr ? std::string(" ") + picture : "");
  std::string line, last;
  FILE* const pipe = popen(command.c_str(), "r");
  char text[4096];
  while (pipe != nullptr && std::fgets(text, sizeof text, pipe) != nullptr) {
    line += text;
    if (line.back() != '\n') continue;
    last = line;
    line.clear();
  }
  EXPECT_EQ(pclose(pipe), 0) << command;
  std::printf("%s", last.c_str());
  const json out = json::parse(last, nullptr, false);
  EXPECT_TRUE(out.is_object()) << last;
  EXPECT_EQ(out.value("errors", json{"no answer"}), json::array());
  return out;
}

bool has_browser() {
  const char* const other = std::getenv("PIRVS_CHROMIUM");
  const bool has = fs::exists(other != nullptr ? other : "/usr/bin/chromium");
  if (!has) std::printf("skipped: no /usr/bin/chromium\n");
  return has;
}

// As long as the clicks take.
std::string recording() {
  if (clip() != nullptr) return clip()->folder;
  tools::SimOptions options;
  options.duration_s = 30;
  static const std::string folder = made(options, "view").folder;
  return folder;
}

// Pictures are drawn by the processor here, beside the estimator and whatever else it does: where
// not even an empty page comes to twice the rate that is wanted, that much less is.
void expect_fluent(const json& seen) {
  constexpr double kDrawn_hz = 30, kLag_ms = 100;
  const double empty_hz = seen["empty_hz"];
  const double share = std::min(1.0, empty_hz / (1.8 * kDrawn_hz));
  EXPECT_GE(seen["measured"]["drawn_hz"], share * kDrawn_hz);
  EXPECT_LE(seen["measured"]["lag_ms"]["median"], kLag_ms / share);
}

TEST(view, a_replay_is_followed_and_obeys_every_button) {
  if (!has_browser()) GTEST_SKIP();
  const json seen = looked_at("replay", recording(), scratch_folder("view_maps"));
  ASSERT_TRUE(seen.contains("exit_status"));
  expect_fluent(seen);
  EXPECT_GE(seen["measured"]["images_hz"], 4);  // of both cameras; 24 on a machine at rest
  EXPECT_GT(seen["map"]["points"], 100);
  EXPECT_GT(seen["map"]["path"], 10);
  EXPECT_GT(seen["map"]["keyframes"], 2);
  EXPECT_EQ(seen["map"]["health"], "tracking");
  EXPECT_EQ(seen["layers"], 6);
  EXPECT_GT(seen["top"], 0.99);
  EXPECT_EQ(seen["follows_after_fit"], false);
  for (const char* const what : {"follows", "theme_changes", "help_opens", "help_closes"}) {
    EXPECT_EQ(seen[what], true) << what;
  }
  EXPECT_EQ(seen["answers"], (json{{"pose", "ok pose"},
                                   {"parameter", "ok parameter"},
                                   {"wrong", "error parameter: not found"},
                                   {"save", "ok map save"},
                                   {"load", "ok map load"},
                                   {"reset", "ok reset"}}));
  EXPECT_NE(seen["foreign"], "taken");
  EXPECT_NE(seen["rebound"], "taken");
  EXPECT_EQ(seen["own"], "taken");
  EXPECT_LT(seen["reconnect_ms"], 10'000);
  EXPECT_EQ(seen["exit_status"], 0);
}

TEST(view, a_device_that_goes_and_comes_is_followed) {
  if (!has_browser()) GTEST_SKIP();
  const json seen = looked_at("device", "-", "-");
  ASSERT_TRUE(seen.contains("came_back"));
  expect_fluent(seen);
  EXPECT_NEAR(seen["radius"], 1, 1e-3);
  EXPECT_NEAR(seen["confidence"], 0.75, 1e-3);
}

TEST(view, a_finished_run_has_a_slider) {
  if (!has_browser()) GTEST_SKIP();
  const std::string run = scratch_folder("view_run");
  const std::string command = build_folder() + "/host/pirvs run " + recording() + " --out " + run +
                              " --duration 5 >/dev/null 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const json seen = looked_at("run", run, "-");
  for (const char* const what : {"slider_moves", "key_moves", "plays"}) {
    EXPECT_EQ(seen.value(what, false), true) << what;
  }
  EXPECT_GT(seen.value("rows", 0), 50);
}

}  // namespace
}  // namespace pirvs::systems
