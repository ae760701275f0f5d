// Tools in Python are tested in Python: each folder of tools with a *_test.py is a test here.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace {

std::vector<std::string> folders() {
  std::vector<std::string> out;
  for (const auto& tool : std::filesystem::directory_iterator("tools")) {
    if (!tool.is_directory()) continue;
    const std::string name = tool.path().filename().string();
    if (std::filesystem::exists(tool.path() / (name + "_test.py"))) out.push_back(name);
  }
  std::sort(out.begin(), out.end());
  return out;
}

class Python : public testing::TestWithParam<std::string> {};

// Debian's own Python: it has Debian's modules.
TEST_P(Python, TestsPass) {
  const std::string command =
      "/usr/bin/python3 -B -m unittest discover -q -s tools/" + GetParam() + " -p '*_test.py'";
  EXPECT_EQ(std::system(command.c_str()), 0);  // NOLINT(cert-env33-c): our own words
}

INSTANTIATE_TEST_SUITE_P(Tools, Python, testing::ValuesIn(folders()),
                         [](const auto& tool) { return tool.param; });

}  // namespace
