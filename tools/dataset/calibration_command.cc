// `pirvs calibration`: a calibration as a device reads it (modules/calibration/calibration_text.h).
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "modules/calibration/calibration_text.h"
#include "tools/cli/command.h"
#include "tools/dataset/calibration_file.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string in, out, imu;
};

Calibration read(const Options& options) {
  if (fs::is_directory(options.in)) {
    const std::string mav0 = options.in + "/mav0";
    return read_asl_calibration(fs::is_directory(mav0) ? mav0 : options.in);
  }
  const ImuNoise noise = options.imu.empty() ? ImuNoise{} : read_imu_noise(options.imu);
  return read_calibration_file(options.in, noise);
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
  app.add_option("IN", o->in, "an ASL/EuRoC folder, or Kalibr's camchain-imucam.yaml")->required();
  app.add_option("--out", o->out, "the device's calibration file")->required();
  app.add_option("--imu", o->imu,
                 "noise densities, Kalibr's imu.yaml or an ASL sensor.yaml, where none stands "
                 "beside the camchain");
  return [o] { return convert(*o); };
}

}  // namespace

const Command kCalibrationCommand = {"calibration", "Write a calibration as a device reads it",
                                     declare};

}  // namespace pirvs::tools
