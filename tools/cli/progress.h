// What    A progress bar on stderr; silent unless that is a terminal.
// In      what is being done, how much there is, how far it has come (from any one thread).
// Out     one line, redrawn at most ten times a second, wiped at the end.
// Errors  none.
// Cost    a clock read per update.
#pragma once

#include <cstddef>
#include <string>

namespace pirvs::tools {

class Progress {
 public:
  Progress(const std::string& what, size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(size_t done, const std::string& note = "");

 private:
  std::string what_;
  size_t total_;
  bool visible_;
  double begin_s_;
  double drawn_s_ = 0;
};

}  // namespace pirvs::tools
