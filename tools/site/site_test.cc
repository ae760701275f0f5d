// The pages are tested in Python: tools/site/site_test.py.
#include <gtest/gtest.h>

#include <cstdlib>

namespace {

TEST(site, tests_in_python_pass) {
  const char* const command =
      "/usr/bin/python3 -B -m unittest discover -q -s tools/site -p '*_test.py'";
  EXPECT_EQ(std::system(command), 0);  // NOLINT(cert-env33-c): our own words
}

}  // namespace
