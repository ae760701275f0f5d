// The fleet is tested in its own language, with mosquitto if it is here: tools/fleet/fleet_test.py.
#include <gtest/gtest.h>

#include <cstdlib>

namespace {

TEST(fleet, tests_in_python_pass) {
  const char* const command =
      "/usr/bin/python3 -B -m unittest discover -q -s tools/fleet -p '*_test.py'";
  EXPECT_EQ(std::system(command), 0);  // NOLINT(cert-env33-c): our own words
}

}  // namespace
