// The sweep is tested in its own language, with Slurm if it is here: tools/sweep/sweep_test.py.
#include <gtest/gtest.h>

#include <cstdlib>

namespace {

TEST(sweep, tests_in_python_pass) {
  const char* const command = "python3 -B -m unittest discover -q -s tools/sweep -p '*_test.py'";
  EXPECT_EQ(std::system(command), 0);  // NOLINT(cert-env33-c): our own words
}

}  // namespace
