// What    What was odd about an input and did not stop it: counted by name for summary.json, and
//         said in words on the console.
// In      count(): one more of a kind. note(): a sentence without a full stop.
// Errors  none.
// Source  README.md: bad input gets one clear line.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace pirvs::tools {

struct Count {
  std::string name;
  size_t value = 0;
};

struct InputLog {
  std::vector<Count> rejected;
  std::vector<std::string> notes;

  void count(const std::string& name, size_t value = 1) {
    if (value == 0) return;
    for (Count& c : rejected) {
      if (c.name != name) continue;
      c.value += value;
      return;
    }
    rejected.push_back({name, value});
  }
  size_t counted(const std::string& name) const {
    for (const Count& c : rejected) {
      if (c.name == name) return c.value;
    }
    return 0;
  }
  void note(const std::string& text) {
    for (const std::string& said : notes) {
      if (said == text) return;
    }
    notes.push_back(text);
  }
};

}  // namespace pirvs::tools
