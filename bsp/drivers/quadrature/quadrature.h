// Quadrature decoder: counts the ticks of an incremental encoder from the edges of its two pins.
// In      add(): each edge in order, its pin (0 A, 1 B) and the level after it; lost(): edges were
//         lost before the next one.
// Out     ticks(): four a period, growing while A leads B.
// Errors  An edge that does not change its pin's level was lost by its partner: the encoder has
//         turned by two or four ticks, nobody knows which way. It is counted and moves nothing.
// Cost    ~2 ns an edge.
// Source  Gray code 00 10 11 01 of (A, B).
#pragma once

#include <cstdint>

namespace pirvs::bsp {

class Quadrature {
 public:
  void set_levels(bool a, bool b) {
    level_[0] = a;
    level_[1] = b;
    known_[0] = known_[1] = true;
  }

  void add(int pin, bool level) {
    const bool moved = known_[pin] && level_[pin] != level;
    if (known_[pin] && !moved) ++missed_;
    level_[pin] = level;
    known_[pin] = true;
    if (!moved || !known_[1 - pin]) return;
    // A's edge leads when it leaves B's level, B's when it comes to A's.
    const bool forward = pin == 0 ? level_[0] != level_[1] : level_[0] == level_[1];
    ticks_ += forward ? 1 : -1;
  }
  void lost(uint32_t edges) {
    missed_ += edges;
    known_[0] = known_[1] = false;
  }

  int64_t ticks() const { return ticks_; }
  uint32_t missed() const { return missed_; }

 private:
  bool level_[2] = {};
  bool known_[2] = {};
  int64_t ticks_ = 0;
  uint32_t missed_ = 0;
};

}  // namespace pirvs::bsp
