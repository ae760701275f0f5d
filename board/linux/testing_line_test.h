// For tests: a serial line that may be plugged and pulled. A pseudo terminal, of which the test is
// the host, with a link to its other end where a device would be.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <string>

namespace pirvs::board {

class TestingLine {
 public:
  explicit TestingLine(const std::string& name)
      : path_(::testing::TempDir() + name + std::to_string(getpid())) {}
  TestingLine(const TestingLine&) = delete;
  TestingLine& operator=(const TestingLine&) = delete;
  ~TestingLine() { unplug(); }

  void plug() {
    host_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(host_, 0);
    ASSERT_EQ(grantpt(host_), 0);
    ASSERT_EQ(unlockpt(host_), 0);
    ASSERT_EQ(symlink(ptsname(host_), path_.c_str()), 0);
  }
  void unplug() {
    if (host_ >= 0) close(host_);
    host_ = -1;
    unlink(path_.c_str());
  }
  void type(const std::string& text) {
    ASSERT_EQ(write(host_, text.data(), text.size()), ssize_t(text.size()));
  }
  // What has come since; nothing while it is pulled.
  std::string heard() {
    std::string out;
    char bytes[4096];
    for (ssize_t got = 0; host_ >= 0 && (got = read(host_, bytes, sizeof bytes)) > 0;) {
      out.append(bytes, size_t(got));
    }
    return out;
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int host_ = -1;
};

}  // namespace pirvs::board
