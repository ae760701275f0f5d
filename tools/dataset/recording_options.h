// What    The options of a command that reads a recording: the same everywhere.
// In      the command's part of the command line.
// Out     a RecordingOptions, filled when it is parsed.
// Errors  those of CLI11, when it is parsed.
#pragma once

#include <CLI/CLI.hpp>

#include "tools/dataset/recording.h"

namespace pirvs::tools {

void add_recording_options(CLI::App& app, RecordingOptions& options);
// One line each on stderr.
void print_notes(const InputLog& log);

}  // namespace pirvs::tools
