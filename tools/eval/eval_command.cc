// `pirvs eval EST GT`: ATE and RPE of a trajectory, as one line.
#include <cstdio>
#include <memory>

#include "tools/cli/command.h"
#include "tools/eval/eval.h"

namespace pirvs::tools {
namespace {

struct Options {
  std::string estimate;
  std::string truth;
  double delta_s = 1.0;
};

std::function<int()> declare(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  app.add_option("EST", options->estimate, "estimated trajectory (TUM)")->required();
  app.add_option("GT", options->truth, "ground truth (ASL data.csv or TUM)")->required();
  app.add_option("--delta", options->delta_s, "seconds of motion that the RPE compares")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  return [options] {
    const Trajectory estimate = read_trajectory(options->estimate);
    const Trajectory truth = read_trajectory(options->truth);
    const Evaluation result = evaluate(estimate, truth, options->delta_s);
    std::printf("%s\n", to_line(result).c_str());
    return result.ok ? kExitDone : kExitFailed;
  };
}

}  // namespace

const Command kEvalCommand = {"eval", "Compare a trajectory with ground truth: ATE and RPE",
                              declare};

}  // namespace pirvs::tools
