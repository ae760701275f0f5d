// What    What a host program is to `pirvs`: a name, a line of help, options, something to run.
// In      declare() adds the options to its part of the command line.
// Out     declare() returns what runs once the command line is parsed; its int is the exit status.
// Errors  exit status: 0 done, 1 the work failed, 2 bad usage or input (throw InputError).
// Source  DESIGN.md, "The front door".
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace pirvs::tools {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitBadInput = 2;
inline constexpr int kExitSignal = 128;  // and its number: stopped by hand

struct Command {
  const char* name;
  const char* help;
  std::function<int()> (*declare)(CLI::App& options);
};

// One per command, defined beside its code; main.cc lists them in the order of the help.
extern const Command kRunCommand;
extern const Command kEvalCommand;
extern const Command kPackCommand;
extern const Command kConvertCommand;
extern const Command kInfoCommand;
extern const Command kSimCommand;
extern const Command kMapCommand;
extern const Command kListenCommand;
extern const Command kCalibrationCommand;
extern const Command kParamsCommand;
extern const Command kUpdateCommand;
extern const Command kRos2Command;
extern const Command kCalibCommand;
extern const Command kViewCommand;

}  // namespace pirvs::tools
