// The judge of lies is tested in its own language: tools/trust/trust_test.py.
#include <gtest/gtest.h>

#include <cstdlib>

namespace {

TEST(trust_judge, tests_in_python_pass) {
  const char* const command = "python3 -B -m unittest discover -q -s tools/trust -p '*_test.py'";
  EXPECT_EQ(std::system(command), 0);  // NOLINT(cert-env33-c): our own words
}

}  // namespace
