// `pirvs calib target`: a board to print, and its yaml.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "tools/calib/board_drawing.h"
#include "tools/calib/calib_command.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

struct Options {
  Target target;
  std::vector<double> paper;
  double tag_mm = 88;
  std::string out = ".";
};

int run(const Options& o) {
  Target target = o.target;
  target.tag_m = o.tag_mm / 1e3;
  if (target.tags() > kTagsMax) {
    throw InputError("more tags than the family 36h11 has", std::to_string(target.tags()),
                     "ask for fewer --columns or --rows");
  }
  std::error_code error;
  std::filesystem::create_directories(o.out, error);
  Paper paper;
  if (!o.paper.empty()) paper = {o.paper[0], o.paper[1]};
  write_pdf(target, paper, o.out + "/target.pdf");
  write_target(target, o.out + "/target.yaml");
  std::printf(
      "written: %s/target.pdf, target.yaml: %d x %d tags of %.2f mm, %.0f x %.0f mm in all\n",
      o.out.c_str(), target.columns, target.rows, o.tag_mm, 1e3 * target.columns * target.pitch_m(),
      1e3 * target.rows * target.pitch_m());
  std::printf(
      "print at 100 %%, glue it on a flat plate, measure it, correct tagSize in the yaml\n");
  return kExitDone;
}

std::function<int()> declare(CLI::App& app) {
  const auto o = std::make_shared<Options>();
  app.add_option("--columns", o->target.columns, "tags in a row")->check(CLI::Range(1, 60));
  app.add_option("--rows", o->target.rows, "rows of tags")->check(CLI::Range(1, 60));
  app.add_option("--tag", o->tag_mm, "side of a tag, mm")->check(CLI::Range(5.0, 1000.0));
  app.add_option("--spacing", o->target.spacing, "gap between tags over their side")
      ->check(CLI::Range(0.1, 1.0));
  app.add_option("--paper", o->paper, "width and height of the paper, mm; else as needed")
      ->expected(2)
      ->check(CLI::Range(50.0, 5000.0));
  app.add_option("--out", o->out, "folder for target.pdf and target.yaml");
  return [o] { return run(*o); };
}

}  // namespace

const Command kCalibTargetCommand = {"target", "A board to print: AprilGrid as PDF, and its yaml",
                                     declare};

}  // namespace pirvs::tools
