// The host program: `pirvs COMMAND ...`.
#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "core/base/version.h"
#include "tools/cli/command.h"
#include "tools/dataset/input_error.h"

namespace pirvs::tools {
namespace {

const Command* const kCommands[] = {
    &kRunCommand,    &kInfoCommand,    &kEvalCommand, &kSimCommand,         &kMapCommand,
    &kListenCommand, &kConvertCommand, &kPackCommand, &kCalibrationCommand, &kCalibCommand,
    &kParamsCommand, &kUpdateCommand,  &kRos2Command, &kViewCommand};

// One line on stderr, whatever happened.
void print_error(std::string text) {
  for (char& c : text) {
    if (c == '\n') c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  std::fprintf(stderr, "pirvs: %s\n", text.c_str());
}

int parse_and_run(int argc, char** argv) {
  CLI::App app("Visual-inertial SLAM for a stereo camera and an IMU.", "pirvs");
  app.require_subcommand(1);
  app.set_version_flag("--version", kVersion, "Print the version and exit");
  std::vector<std::pair<CLI::App*, std::function<int()>>> runs;
  for (const Command* command : kCommands) {
    CLI::App* options = app.add_subcommand(command->name, command->help);
    runs.emplace_back(options, command->declare(*options));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    const std::string who = argc > 1 && argv[1][0] != '-' ? std::string(argv[1]) + ": " : "";
    print_error(who + error.what() + " (see --help)");
    return kExitBadInput;
  }
  for (const auto& [options, run] : runs) {
    if (options->parsed()) return run();
  }
  return kExitBadInput;
}

}  // namespace
}  // namespace pirvs::tools

int main(int argc, char** argv) {
  using namespace pirvs::tools;
  try {
    return parse_and_run(argc, argv);
  } catch (const InputError& error) {
    print_error(error.what());
    return kExitBadInput;
  } catch (const std::exception& error) {
    print_error(std::string("internal error: ") + error.what());
    return kExitFailed;
  }
}
