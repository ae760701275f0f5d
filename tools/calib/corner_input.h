// What    What the commands of `pirvs calib` share: where corners come from, the lines about
//         cameras.
// In      Options of the command line.
// Out     Shots, board, what else `calibrate_cameras` asks for. Rejected corners are told on
//         stderr.
// Errors  InputError.
#pragma once

#include <string>
#include <vector>

#include "modules/imu/imu_noise.h"
#include "tools/calib/cameras.h"
#include "tools/cli/command.h"

namespace pirvs::tools {

struct CornerOptions {
  std::string sequence;  // images; or
  std::vector<std::string> files;
  std::string target, model;
  std::vector<int> size;
  double rate_hz = 20;          // of images looked at
  double duration_s_max = 1e6;  // likewise
};

struct CornerInput {
  Target target;
  std::vector<Shot> shots;
  int cameras = 1;
  size_t tags_twice = 0;  // dropped: the image has them twice
  double left_out_s = 0;  // beyond duration_s_max
  CameraOptions how;
};

void declare_corners(CLI::App& app, CornerOptions& options);
CornerInput read_corner_input(const CornerOptions& options);
// What was odd about an input, on stderr.
void print_log(const std::string& path, const InputLog& log);
ImuNoise read_noise(const std::string& path);
void print_cameras(const CameraResult& result);

}  // namespace pirvs::tools
