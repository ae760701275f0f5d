// What the fuzzer throws bytes at: one function per parser of outside text.
// In      Any bytes.
// Out     Nothing: it returns, or the process dies. InputError is the right answer to nonsense; any
//         other exception, a sanitizer's finding or a broken promise of the parser is a bug.
// Errors  as above.
// Cost    ~50 us a call.
// Source  libFuzzer; `make fuzz T=name`. tests/fuzz/corpus/NAME holds what has been found worth
//         keeping, and `make test` replays it.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pirvs::fuzz {

struct Target {
  const char* name;
  void (*run)(const uint8_t* data, size_t size);
};

extern const Target kTargets[];
extern const size_t kTargetCount;

// nullptr: no target of that name.
const Target* find_target(const char* name);

}  // namespace pirvs::fuzz
