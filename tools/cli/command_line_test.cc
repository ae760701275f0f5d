#include "tools/cli/command_line.h"

#include <gtest/gtest.h>

namespace pirvs::tools {
namespace {

TEST(command_line, is_as_typed_and_can_be_typed_again) {
  CLI::App app;
  CLI::App* const run = app.add_subcommand("run");
  std::string sequence, out;
  std::vector<std::string> faults;
  bool mono = false;
  run->add_option("SEQ", sequence);
  run->add_option("--out", out);
  run->add_option("--fault", faults)->allow_extra_args(false);
  run->add_flag("--mono", mono);
  app.parse("run --fault black:8-9 'a b' --mono --fault cam1:3-4 --out \"it's\"");
  EXPECT_EQ(command_line(*run),
            "pirvs run --fault black:8-9 'a b' --mono --fault cam1:3-4 --out 'it'\\''s'");
}

}  // namespace
}  // namespace pirvs::tools
