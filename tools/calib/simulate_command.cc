// `pirvs calib simulate`: what a device by seed records of a board, to try `calib device` on.
#include <cstdio>
#include <memory>

#include "tools/calib/board_recording.h"
#include "tools/calib/calib_command.h"

namespace pirvs::tools {
namespace {

struct Options {
  DrawnRecording how;
  uint64_t seed = 1;
  double exposure_ms = 4;
  std::string out;
};

int run(const Options& o) {
  DrawnRecording how = o.how;
  how.exposure_s = o.exposure_ms / 1e3;
  SimulatedDevice device(o.seed);
  write_board_recording(device, how, o.out);
  std::printf("written: %s, %zu pairs; pirvs calib device %s --target %s/target.yaml --out DIR\n",
              o.out.c_str(), device.stamps(how.motion).size(), o.out.c_str(), o.out.c_str());
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  o->how.motion.duration_s = 60;
  o->how.motion.frames_hz = 12;
  o->how.motion.rest_s = 1;
  app.add_option("--seed", o->seed, "the device: lenses, places, IMU, motion")
      ->capture_default_str();
  app.add_option("--out", o->out, "folder to write: an ASL folder, target.yaml, truth")->required();
  app.add_option("--duration", o->how.motion.duration_s, "of the motion, s")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 3600.0));
  app.add_option("--rest", o->how.motion.rest_s, "standstill before and after it, s")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 3600.0));
  app.add_option("--rate", o->how.motion.frames_hz, "pairs of images a second")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 200.0));
  app.add_option("--exposure", o->exposure_ms, "of an image, ms")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--blur", o->how.light.blur_px, "of the lens, one sigma, px")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 20.0));
  app.add_option("--white", o->how.light.white, "grey value of the board's paper")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 255.0));
  app.add_option("--turning", o->how.motion.turning, "share of the usual turns")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.5));
  app.add_option("--moving", o->how.motion.moving, "share of the usual distances")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1.5));
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibSimulateCommand = {
    "simulate", "What a device by seed records of a board, and its true calibration", declare};

}  // namespace pirvs::tools
