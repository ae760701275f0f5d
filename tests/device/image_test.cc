// The card of a device under Linux in QEMU, started through U-Boot as on a board: from power to
// poses, updates that go well and that do not, power cuts, ports. What happens is in
// image_scenarios.py; two run at a time, each on a machine of its own.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <future>
#include <map>
#include <mutex>
#include <sstream>
#include <string>
#include <vector>

#include "modules/calibration/calibration_text.h"
#include "tests/programs.h"
#include "tests/recordings.h"
#include "tools/dataset/pack_file.h"

namespace pirvs::systems {
namespace {

constexpr double kFed_s = 4;
constexpr int kLanes = 2;

struct Outcome {
  int status = -1;
  std::string said;
};

// Each test and its scenario, the longest first.
struct Row {
  const char* test;
  const char* scenario;
};
constexpr Row kRows[] = {
    {"versions_that_fail_give_way_to_the_one_before", "failures"},
    {"tracks_within_ten_seconds_after_power_without_a_login", "boot"},
    {"power_cuts_leave_a_complete_version_and_the_configuration", "cuts"},
    {"takes_an_update_and_refuses_what_is_not_ours_or_not_whole", "update"},
    {"answers_on_the_usb_link_alone_and_as_documented", "ports"},
};

Outcome run_scenario(const std::string& scenario) {
  const std::string out = build_folder() + "/test/image_" + scenario;
  const std::string told = out + ".txt";
  const std::string command = "python3 -B tests/device/image_scenarios.py " + scenario +
                              " --build " + build_folder() + " --out " + out + " > " + told +
                              " 2>&1";
  const int status = std::system(command.c_str());
  std::ostringstream text;
  text << std::ifstream(told).rdbuf();
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text.str()};
}

// What the cameras and the IMU of the test show, and the calibration that a person would copy.
void write_recording() {
  tools::RecordingOptions options;
  options.duration_s = kFed_s;
  const tools::Recording recording =
      tools::open_recording(simulated(SimulatedDevice::kEuroc).folder, options);
  const std::string at = build_folder() + "/test/image";
  tools::write_pack(recording, at + ".pack", [](size_t, size_t) {});
  Text<kCalibrationTextMax> calibration;
  write_calibration(recording.calibration, calibration);
  std::ofstream(at + ".cfg") << calibration.c_str();
  const Camera& camera = recording.calibration.camera[0];
  std::ofstream(at + ".guest") << "width=" << camera.width << "\nheight=" << camera.height << "\n";
}

bool is_wanted(const std::string& test) {
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const testing::TestSuite& suite = *all.GetTestSuite(i);
    for (int k = 0; k < suite.total_test_count(); ++k) {
      const testing::TestInfo& info = *suite.GetTestInfo(k);
      if (test == info.name()) return info.should_run();
    }
  }
  return false;
}

class image : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    write_recording();
    for (const Row& row : kRows) {
      if (is_wanted(row.test)) waiting_.push_back(row.scenario);
      results_[row.scenario];
    }
    for (int lane = 0; lane < kLanes; ++lane) {
      lanes_.push_back(std::async(std::launch::async, run_lane));
    }
  }
  static void TearDownTestSuite() { lanes_.clear(); }

  static void passes(const char* scenario) {
    const Outcome outcome = results_.at(scenario).get_future().get();
    std::printf("%s", outcome.said.c_str());
    EXPECT_EQ(outcome.status, 0) << build_folder() << "/test/image_" << scenario << "/console";
  }

 private:
  static void run_lane() {
    for (;;) {
      std::string scenario;
      {
        const std::lock_guard<std::mutex> hold(mutex_);
        if (waiting_.empty()) return;
        scenario = waiting_.front();
        waiting_.erase(waiting_.begin());
      }
      results_.at(scenario).set_value(run_scenario(scenario));
    }
  }

  static inline std::mutex mutex_;
  static inline std::vector<std::string> waiting_;
  static inline std::map<std::string, std::promise<Outcome>> results_;
  static inline std::vector<std::future<void>> lanes_;
};

TEST_F(image, tracks_within_ten_seconds_after_power_without_a_login) { passes("boot"); }

TEST_F(image, versions_that_fail_give_way_to_the_one_before) { passes("failures"); }

TEST_F(image, takes_an_update_and_refuses_what_is_not_ours_or_not_whole) { passes("update"); }

TEST_F(image, power_cuts_leave_a_complete_version_and_the_configuration) { passes("cuts"); }

TEST_F(image, answers_on_the_usb_link_alone_and_as_documented) { passes("ports"); }

}  // namespace
}  // namespace pirvs::systems
