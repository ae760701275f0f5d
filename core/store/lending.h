// Reference counts of N slots that one core lends and any core gives back: who still reads a camera
// frame, so that its memory is not filled again too soon.
// In      lend(): from the lender's core alone; the slot has one holder then. retain(): by somebody
//         who holds the slot, for one holder more. release(): by each holder, once. Any core.
// Out     release: true to the last holder: what the slot names is nobody's any more. That caller
//         tidies up, undisturbed, and calls recycle(); lend() gives the slot out from then on.
// Errors  lend: kFull, all slots are held (an expected rejection: count it). A handle that is not
//         lent, retained or released, is a bug and asserts.
// Cost    retain, release: one atomic exchange as a rule. lend: a look at N words.
// Source  Intrusive reference counting, as of std::shared_ptr; generations as in pool.h.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/base/assert.h"
#include "core/base/status.h"
#include "core/store/handle.h"

namespace pirvs {

template <class T, size_t N>
class Lending {
  static_assert(N > 0 && N < 65536);

 public:
  Result<Handle<T>> lend() {
    for (size_t slot = 0; slot < N; ++slot) {
      const uint64_t state = states_[slot].load(std::memory_order_acquire);
      if (is_held(state)) continue;
      const uint64_t lent = (state & kGeneration) + kNextGeneration + 1;
      states_[slot].store(lent, std::memory_order_relaxed);
      return Handle<T>{generation(lent), static_cast<uint16_t>(slot)};
    }
    return Status::kFull;
  }

  void retain(Handle<T> handle) { (void)change(handle, +1); }

  [[nodiscard]] bool release(Handle<T> handle) { return holders(change(handle, -1)) == 0; }

  void recycle(Handle<T> handle) {
    std::atomic<uint64_t>& state = state_of(handle);
    const uint64_t now = state.load(std::memory_order_relaxed);
    PIRVS_ASSERT(generation(now) == handle.generation && holders(now) == 0);
    state.store(now + kNextGeneration, std::memory_order_release);
  }

  // How many slots are not free; a bound while other cores work.
  size_t lent() const {
    size_t count = 0;
    for (const auto& state : states_) count += is_held(state.load(std::memory_order_relaxed));
    return count;
  }
  static constexpr size_t capacity() { return N; }

 private:
  // A slot's state: its generation, odd from lend() to recycle(), above the number of its holders.
  static constexpr uint64_t kNextGeneration = uint64_t{1} << 32;
  static constexpr uint64_t kGeneration = ~(kNextGeneration - 1);

  static uint32_t generation(uint64_t state) { return static_cast<uint32_t>(state >> 32); }
  static uint32_t holders(uint64_t state) { return static_cast<uint32_t>(state); }
  static bool is_held(uint64_t state) { return generation(state) % 2 == 1; }

  std::atomic<uint64_t>& state_of(Handle<T> handle) {
    PIRVS_ASSERT(handle.slot < N && handle.generation % 2 == 1);
    return states_[handle.slot];
  }

  // acq_rel: what each holder read of the slot comes before the tidying up of the last one.
  uint64_t change(Handle<T> handle, int by) {
    std::atomic<uint64_t>& state = state_of(handle);
    uint64_t before = state.load(std::memory_order_relaxed), after = 0;
    do {
      PIRVS_ASSERT(generation(before) == handle.generation && holders(before) > 0);
      after = before + static_cast<uint64_t>(static_cast<int64_t>(by));
    } while (!state.compare_exchange_weak(before, after, std::memory_order_acq_rel,
                                          std::memory_order_relaxed));
    return after;
  }

  std::atomic<uint64_t> states_[N] = {};
};

}  // namespace pirvs
