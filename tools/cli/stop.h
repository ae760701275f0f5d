// What    Ctrl-C and SIGTERM ask a command that runs until it is stopped to end in order.
// Out     stop_wanted: the signal's number once one came, else 0.
// Source  POSIX signal().
#pragma once

#include <csignal>

namespace pirvs::tools {

inline volatile std::sig_atomic_t stop_wanted = 0;

inline void stop_by_signals() {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, [](int number) { stop_wanted = number; });
  }
}

}  // namespace pirvs::tools
