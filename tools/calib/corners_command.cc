// `pirvs calib corners`: the corners of a board in a recording's images, as tables.
#include <cstdio>
#include <memory>

#include "tools/calib/board_images.h"
#include "tools/calib/calib_command.h"
#include "tools/calib/corner_input.h"

namespace pirvs::tools {
namespace {

constexpr double kWhole_s = 1e6;

struct Options {
  std::string sequence, target, out;
  double rate_hz = 20;
};

int run(const Options& o) {
  InputLog log;
  const BoardImages found =
      find_boards(o.sequence, read_target(o.target), o.rate_hz, kWhole_s, log);
  print_log(o.sequence, log);
  for (int c = 0; c < found.cameras; ++c) {
    size_t corners = 0;
    for (const ImageCorners& image : found.images[c]) corners += image.corners.size();
    std::printf("cam%d: %zu images, %zu tags\n", c, found.images[c].size(), corners / 4);
    if (o.out.empty()) continue;
    write_corners(found.images[c], o.out + "/cam" + std::to_string(c) + "_corners.csv");
  }
  if (!o.out.empty()) std::printf("written: %s\n", o.out.c_str());
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("SEQ", o->sequence, "an ASL folder: images need no calibration")->required();
  app.add_option("--target", o->target, "the board's yaml")->required();
  app.add_option("--rate", o->rate_hz, "images a second to look at, at most")
      ->check(CLI::Range(0.1, 1000.0));
  app.add_option("--out", o->out, "folder for cam0_corners.csv, cam1_corners.csv");
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibCornersCommand = {"corners", "Corners of a board in a recording's images",
                                      declare};

}  // namespace pirvs::tools
