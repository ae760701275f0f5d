// `pirvs calib cameras`: intrinsics and stereo extrinsics from views of a board.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/calib/calib_command.h"
#include "tools/calib/corner_input.h"
#include "tools/calib/result_files.h"

namespace pirvs::tools {
namespace {

struct Options {
  CornerOptions corners;
  std::string out;
};

int run(const Options& o) {
  const CornerInput input = read_corner_input(o.corners);
  const CameraResult result =
      calibrate_cameras(input.target, input.shots, input.cameras, input.how);
  print_cameras(result);
  if (o.out.empty()) return kExitDone;
  const double no_offset[2] = {0, 0};
  write_camchain(o.out, result.rig, no_offset, nullptr);
  write_json(o.out + "/calibration.json", camera_json(result));
  std::printf("written: %s\n", o.out.c_str());
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  declare_corners(app, o->corners);
  app.add_option("--out", o->out, "folder for camchain.yaml and calibration.json");
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibCamerasCommand = {
    "cameras", "Intrinsics of cameras and where they stand against each other", declare};

}  // namespace pirvs::tools
