#include "tests/programs.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

namespace pirvs::systems {

std::string build_folder() {
  const char* const folder = std::getenv("PIRVS_BUILD");
  return folder != nullptr ? folder : "build";
}

std::string said_by(const std::string& command) {
  std::string out;
  std::FILE* const pipe = popen(command.c_str(), "r");
  char text[4096];
  while (pipe != nullptr && std::fgets(text, sizeof text, pipe) != nullptr) out += text;
  EXPECT_EQ(pclose(pipe), 0) << command << "\n" << out;
  return out;
}

}  // namespace pirvs::systems
