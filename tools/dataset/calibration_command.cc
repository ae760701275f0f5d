// `pirvs calibration`: a calibration as a device reads it (modules/calibration/calibration_text.h).
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "modules/calibration/calibration_text.h"
#include "tools/cli/command.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"
#include "tools/dataset/recording_options.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string in, out, imu, size;
  std::vector<int> cameras;
};

Calibration read(const Options& options) {
  RigOptions how;
  if (int width = 0, height = 0; !options.size.empty()) {
    char rest = 0;
    if (std::sscanf(options.size.c_str(), "%dx%d%c", &width, &height, &rest) != 2) {
      throw InputError("not a size", "--size " + options.size, "give it as 848x480");
    }
    how.image_size = [=] { return std::pair(width, height); };
  }
  how.imu = options.imu;
  how.cameras = options.cameras;
  how.as_mounted = true;
  InputLog log;
  const std::string mav0 = options.in + "/mav0";
  Rig rig = fs::is_directory(options.in)
                ? read_asl_rig(fs::is_directory(mav0) ? mav0 : options.in, how, log)
                : read_rig(options.in, how, log);
  print_notes(log);
  return rig.calibration;
}

int convert(const Options& options) {
  const Calibration calibration = read(options);
  check_sense(calibration, options.in);
  Text<kCalibrationTextMax> text;
  write_calibration(calibration, text);
  std::ofstream file(options.out, std::ios::binary);
  file << "# Calibration of a device, written by `pirvs calibration`.\n" << text.c_str();
  file.close();
  if (!file) throw InputError("cannot write", options.out, "check space and permissions");
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("IN", o->in,
                 "an ASL/EuRoC folder, Kalibr's camchain-imucam.yaml or another calibration of "
                 "docs/formats.md")
      ->required();
  app.add_option("--out", o->out, "the device's calibration file")->required();
  app.add_option("--imu", o->imu,
                 "noise densities, Kalibr's imu.yaml or an ASL sensor.yaml, where none stands "
                 "beside the camchain");
  app.add_option(
      "--size", o->size,
      "WIDTHxHEIGHT of the images, where IN has lenses for several (RealSense, DepthAI)");
  app.add_option("--cameras", o->cameras, "LEFT,RIGHT, or one alone, as numbered in IN")
      ->delimiter(',')
      ->expected(1, 2)
      ->allow_extra_args(false);
  return [o] { return convert(*o); };
}

}  // namespace

const Command kCalibrationCommand = {"calibration", "Write a calibration as a device reads it",
                                     declare};

}  // namespace pirvs::tools
