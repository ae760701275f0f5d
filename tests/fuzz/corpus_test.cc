// What the fuzzer has found worth keeping, once more: no clang needed.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "tests/fuzz/targets.h"

namespace pirvs::fuzz {
namespace {

namespace fs = std::filesystem;

class corpus : public testing::TestWithParam<size_t> {};

TEST_P(corpus, is_parsed_or_refused) {
  const Target& target = kTargets[GetParam()];
  const fs::path folder = fs::path("tests/fuzz/corpus") / target.name;
  ASSERT_TRUE(fs::is_directory(folder)) << "run from the root of the repository";
  std::vector<fs::path> files;
  for (const auto& file : fs::directory_iterator(folder)) files.push_back(file.path());
  std::sort(files.begin(), files.end());
  EXPECT_GE(files.size(), 2u) << "a target needs a seed that parses and one that does not";
  for (const fs::path& file : files) {
    SCOPED_TRACE(file.string());
    std::ostringstream bytes;
    bytes << std::ifstream(file, std::ios::binary).rdbuf();
    const std::string text = bytes.str();
    target.run(reinterpret_cast<const uint8_t*>(text.data()), text.size());
  }
  target.run(nullptr, 0);
}

INSTANTIATE_TEST_SUITE_P(fuzz, corpus, testing::Range(size_t{0}, kTargetCount),
                         [](const auto& info) { return kTargets[info.param].name; });

}  // namespace
}  // namespace pirvs::fuzz
