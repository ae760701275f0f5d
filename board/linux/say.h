// Lines for whoever runs the program, on standard error.
// In      From any thread: a line is one call of the system.
#pragma once

#include "bsp/api/console.h"
#include "core/base/text.h"

namespace pirvs::board {

inline void say(TextWriter& line) {
  line.put('\n');
  bsp::console_write(line.c_str());
  line.clear();
}

// pirvsd: where: what
inline void say(const char* where, const char* what) {
  Text<512> line;
  line.put("pirvsd: ").put(where).put(": ").put(what);
  say(line);
}

}  // namespace pirvs::board
