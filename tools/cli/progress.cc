#include "tools/cli/progress.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace pirvs::tools {
namespace {

constexpr double kRedraw_s = 0.1;

double now_s() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

}  // namespace

Progress::Progress(const std::string& what, size_t total)
    : what_(what), total_(total), visible_(isatty(STDERR_FILENO) != 0), begin_s_(now_s()) {}

Progress::~Progress() {
  if (visible_) std::fputs("\r\033[K", stderr);
}

void Progress::update(size_t done, const std::string& note) {
  if (!visible_ || total_ == 0) return;
  const double now = now_s();
  if (now - drawn_s_ < kRedraw_s) return;
  drawn_s_ = now;
  constexpr int kWidth = 30;
  std::string bar;
  const int full = int(done * kWidth / total_);
  for (int i = 0; i < kWidth; ++i) bar += i < full ? "━" : "·";
  const double spent_s = now - begin_s_;
  const double left_s = done > 0 ? spent_s * double(total_ - done) / double(done) : 0;
  std::fprintf(stderr, "\r\033[K%s %s %3zu %%  %zu/%zu  %.0f s left  %s", what_.c_str(),
               bar.c_str(), done * 100 / total_, done, total_, left_s, note.c_str());
  std::fflush(stderr);
}

}  // namespace pirvs::tools
