// `pirvs view` in a browser: headless Chromium, driven by browser.cjs with real clicks.
// In      PIRVS_BUILD (default build): host/pirvs, view/view.html, and view-test/node_modules that
//         make fetches. PIRVS_CHROMIUM: another browser. The clip, else a simulated recording.
//         PIRVS_PICTURES: the folder whose pictures of the page are drawn anew.
// Cost    60 s, most of it in real time; the pictures 150 s.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/programs.h"
#include "tests/recordings.h"

namespace pirvs::systems {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

// The last line of what it says.
json looked_at(const std::string& what, const std::string& source, const std::string& folder) {
  const std::string command = "NODE_PATH=" + build_folder() +
                              "/view-test/node_modules timeout 180 node tests/view/browser.cjs " +
                              build_folder() + "/host/pirvs " + what + " " + source + " " + folder;
  std::string last = said_by(command);
  const size_t end = last.size() > 1 ? last.rfind('\n', last.size() - 2) : std::string::npos;
  if (end != std::string::npos) last.erase(0, end + 1);
  std::printf("%s", last.c_str());
  const json out = json::parse(last, nullptr, false);
  EXPECT_TRUE(out.is_object()) << last;
  EXPECT_EQ(out.value("errors", json{"no answer"}), json::array());
  return out;
}

void pirvs(const std::string& words) {
  const std::string command = build_folder() + "/host/pirvs " + words + " >/dev/null 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

// Not each day: a browser is 360 MB to fetch.
bool has_browser() {
  if (std::getenv("PIRVS_NIGHTLY") == nullptr) {
    std::printf("skipped: for make nightly\n");
    return false;
  }
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
  json answers = seen["answers"];
  const std::string node = answers["node get"], begin = "ok node get ";
  ASSERT_EQ(node.rfind(begin, 0), 0U) << answers;
  EXPECT_NEAR(std::stod(node.substr(begin.size())), 10, 3);
  answers.erase("node get");
  EXPECT_EQ(answers, (json{{"pose", "ok pose"},
                           {"node set", "ok node set"},
                           {"node remove", "ok node remove"},
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
  EXPECT_EQ(seen["in_map"], "localised in map");
  const std::string load = seen["load"];
  EXPECT_EQ(load.rfind("CPU ", 0), 0U) << load;
  EXPECT_NE(load.find("49 °C"), std::string::npos) << load;
  EXPECT_EQ(seen["answers"]["record"], "ok record start");
  EXPECT_EQ(seen["answers"]["reset"], "ok reset");
  EXPECT_EQ(seen["answers"]["gone"].get<std::string>().rfind("error ", 0), 0U) << seen;
}

TEST(view, a_finished_run_has_a_slider) {
  if (!has_browser()) GTEST_SKIP();
  const std::string run = scratch_folder("view_run");
  pirvs("run " + recording() + " --duration 5 --out " + run);
  const json seen = looked_at("run", run, "-");
  EXPECT_EQ(seen.value("saver_status", 1), 0);
  const json saved = seen.value("saved", json::object());
  const json report = seen.value("report", json::object());
  for (const json& page : {seen, saved, report}) {
    for (const char* const what : {"slider_moves", "key_moves", "plays"}) {
      EXPECT_EQ(page.value(what, false), true) << what;
    }
    EXPECT_GT(page.value("rows", 0), 50);
  }
  EXPECT_GT(seen.value("earlier", 0), 0);
  EXPECT_GT(seen.value("cursors", 0), 3) << "the slider moves the line in the report's figures";
}

// Of a hall that was mapped on another flight, and with a receiver of GNSS: all that it shows.
TEST(view, pictures_of_the_docs_are_drawn_anew) {
  if (!has_browser()) GTEST_SKIP();
  const char* const pictures = std::getenv("PIRVS_PICTURES");
  if (pictures == nullptr) GTEST_SKIP() << "PIRVS_PICTURES says where to";
  const std::string folder = scratch_folder("view_pictures");
  const std::string sim = "sim --room 3 --boxes 80 --rest 0.5 --format pgm --out " + folder;
  pirvs(sim + "/monday --seed 1 --duration 40");
  pirvs(sim + "/tuesday --seed 2 --duration 40 --gnss rtk");
  pirvs("run " + folder + "/monday --out " + folder + "/before --save-map " + folder +
        "/monday.map");
  pirvs("run " + folder + "/tuesday --out " + folder + "/run --load-map " + folder + "/monday.map");
  const json seen = looked_at("pictures", folder + "/tuesday", folder);
  for (const char* const name : {"view-dark.webp", "view-light.webp", "view-run.webp"}) {
    const fs::path picture = fs::path(folder) / name;
    ASSERT_TRUE(fs::exists(picture)) << seen;
    EXPECT_GT(fs::file_size(picture), 30'000) << name;
    EXPECT_LT(fs::file_size(picture), 150'000) << name;
    fs::copy_file(picture, fs::path(pictures) / name, fs::copy_options::overwrite_existing);
  }
}

}  // namespace
}  // namespace pirvs::systems
