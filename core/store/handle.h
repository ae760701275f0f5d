// A typed name of a slot that goes stale when the slot is released.
// In      Made by whoever keeps the slots (pool.h, lending.h); a default Handle is never live.
// Errors  none here: who keeps the slots tells stale from live by the generation.
// Source  STYLE principle 8: 32 bits last 2^31 uses of one slot, 16 days at 1500 a second.
#pragma once

#include <cstdint>

namespace pirvs {

template <class T>
struct Handle {
  uint32_t generation = 0;
  uint16_t slot = 0;

  bool valid() const { return generation != 0; }
  bool operator==(Handle other) const {
    return generation == other.generation && slot == other.slot;
  }
  bool operator!=(Handle other) const { return !(*this == other); }
};

}  // namespace pirvs
