// Numbers that look random, for samples of a consensus: the same input gives the same ones.
// In      how many there are to choose from.
// Out     below(n): 0 .. n - 1.
// Errors  none.
// Cost    ~1 ns.
// Source  linear congruential generator, Press et al., Numerical Recipes, section 7.1.
#pragma once

#include <cstdint>

namespace pirvs {

struct RandomGenerator {
  uint32_t state = 12345;
  uint32_t below(uint32_t n) {
    state = state * 1664525u + 1013904223u;
    return static_cast<uint32_t>((static_cast<uint64_t>(state) * n) >> 32);
  }
};

}  // namespace pirvs
