// pirvsd for arm64 under Debian's kernel in QEMU: a recording through real device nodes, a robot at
// its pins. What a test wants of a run, and what came of it.
// In      tools/device/run, build/ironsides/pirvsd, the test's modules and programs (make
//         test-device builds them); PIRVS_BUILD: the build folder.
// Cost    ~15 s of this machine for 8 s of a recording.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/dataset/recording.h"

namespace pirvs::systems {

struct GuestSetup {
  std::string name;       // of the run's folder
  bool faults = false;    // what guest/feeder.cc lists
  bool icm20602 = false;  // the IMU as a chip on I2C, else by the kernel's driver
  bool record = true;
  bool trouble = false;  // the clock is set, memory runs out, and the disk that is recorded on
  bool grid = false;     // images at multiples of 50 ms of the guest's clock
  double loop_s = 0;     // so long the recording's end is played again and again
  double cut_s = 0;      // after so long the power goes; recorded is on `disk`
  std::string disk;      // a file with an ext4 file system
  int timeout_s = 500;   // of this machine
  std::string robot = "0.1 0 0";  // words for guest/robot.cc
  std::string config;             // more lines of device.cfg
  std::string camera;             // more words for guest/test_camera.c
};

// What pirvsd told at its end, the feeder and the robot.
struct DeviceRun {
  int status = -1;
  std::string folder, news, console, fed, lines, pins;
  std::map<std::string, uint64_t> counters;
  TimeNs shift = 0;  // from the recording's time to the guest's

  uint64_t counter(const std::string& name) const {
    const auto found = counters.find(name);
    return found == counters.end() ? 0 : found->second;
  }
  bool says(const std::string& text) const { return news.find(text) != std::string::npos; }
  // Times of the robot's lines `what T`, or `what T LEVEL` of that level.
  std::vector<TimeNs> robot_times(const std::string& what, int level = -1) const;
};

DeviceRun run_guest(const tools::Recording& recording, const GuestSetup& setup);
// Runs that tests share, of fed_recording() with all pins in use: nothing goes wrong, or what
// guest/feeder.cc lists, and then nothing is recorded.
const DeviceRun& good_run(bool icm20602);
const DeviceRun& faulty_run(bool icm20602);
std::string text_of(const std::string& path);

// The first seconds of the real clip where it is, else of a simulated flight.
const tools::Recording& fed_recording();

}  // namespace pirvs::systems
