// The packages are tested in Python: tools/deb/deb_test.py.
#include <gtest/gtest.h>

#include <cstdlib>

namespace {

TEST(deb, tests_in_python_pass) {
  const char* const command = "python3 -B -m unittest discover -q -s tools/deb -p '*_test.py'";
  EXPECT_EQ(std::system(command), 0);  // NOLINT(cert-env33-c): our own words
}

}  // namespace
