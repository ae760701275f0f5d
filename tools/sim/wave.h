// What    Two sine waves on top of each other whose periods have no common multiple: a motion that
//         never comes back to the same place and never goes far.
// In      amplitude of the first; its period, made up to 15 % longer or shorter; second: amplitude
//         of the other, as a share of the first.
// Out     the sum at a time.
// Errors  none.
#pragma once

#include "tools/sim/random.h"

namespace pirvs::tools {

struct Wave {
  double amplitude, period_s, phase, second, second_phase;
  double at(double t_s) const {
    const double w = 2 * M_PI / period_s;
    return amplitude *
           (std::sin(w * t_s + phase) + second * std::sin(2.37 * w * t_s + second_phase));
  }
};

inline Wave random_wave(Random& random, double amplitude, double period_s, double second) {
  return {amplitude, period_s * random.uniform(0.85, 1.15), random.uniform(0, 2 * M_PI), second,
          random.uniform(0, 2 * M_PI)};
}

}  // namespace pirvs::tools
