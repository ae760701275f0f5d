#include "tests/recordings.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace pirvs::systems {
namespace {

namespace fs = std::filesystem;

// All that the tests write, gone when the process ends.
struct Scratch {
  fs::path root = fs::temp_directory_path() / ("pirvs_systems_" + std::to_string(getpid()));
  ~Scratch() {
    std::error_code error;
    fs::remove_all(root, error);
  }
};

tools::Recording make(SimulatedDevice device) {
  const bool fisheye = device == SimulatedDevice::kIronsides;
  tools::SimOptions options;
  options.device = fisheye ? "ironsides" : "euroc";
  options.duration_s = 6;
  options.rate_hz = fisheye ? 30 : 20;  // half of the fisheye's own: drawing takes the time
  options.blur = 2;
  return made(options, options.device);
}

}  // namespace

tools::Recording made(tools::SimOptions options, const std::string& name) {
  options.out = scratch_folder(name);
  tools::simulate(options, [](size_t, size_t) {});
  return tools::open_recording(options.out, {});
}

std::string scratch_folder(const std::string& name) {
  static const Scratch scratch;
  const fs::path folder = scratch.root / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder.string();
}

const tools::Recording* clip() {
  const char* const root = std::getenv("PIRVS_DATA");
  const std::string folder = std::string(root ? root : "../shared/data") + "/euroc_mh01_clip";
  if (!fs::is_directory(folder)) {
    std::printf("no recording at %s: set PIRVS_DATA\n", folder.c_str());
    return nullptr;
  }
  static const tools::Recording recording = tools::open_recording(folder, {});
  return &recording;
}

const tools::Recording& simulated(SimulatedDevice device) {
  if (device == SimulatedDevice::kEuroc) {
    static const tools::Recording euroc = make(SimulatedDevice::kEuroc);
    return euroc;
  }
  static const tools::Recording ironsides = make(SimulatedDevice::kIronsides);
  return ironsides;
}

}  // namespace pirvs::systems
