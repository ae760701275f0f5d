// Queue from one writer core to one reader core, lock-free, first in first out.
// In      begin_push() lends the next free item to fill, end_push() hands it over; or push().
// Out     front() is the oldest item and stays valid until pop().
// Errors  begin_push: nullptr, push: false when all N items wait (count the drop).
//         front: nullptr when empty. pop of an empty ring is a bug and asserts.
// Cost    One atomic load and one store per call; no copy unless push() is used.
// Source  Lamport, "Specifying Concurrent Program Modules", TOPLAS 1983: each index has one writer.
#pragma once

#include <atomic>
#include <cstddef>

#include "core/base/assert.h"

namespace pirvs {

template <class T, size_t N>
class Ring {
  static_assert(N > 0);

 public:
  [[nodiscard]] T* begin_push() {
    const size_t pushed = pushed_.load(std::memory_order_relaxed);
    if (pushed - popped_.load(std::memory_order_acquire) == N) return nullptr;
    return &items_[pushed % N];
  }
  void end_push() {
    pushed_.store(pushed_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }
  [[nodiscard]] bool push(const T& item) {
    T* slot = begin_push();
    if (slot == nullptr) return false;
    *slot = item;
    end_push();
    return true;
  }

  [[nodiscard]] T* front() {
    const size_t popped = popped_.load(std::memory_order_relaxed);
    if (pushed_.load(std::memory_order_acquire) == popped) return nullptr;
    return &items_[popped % N];
  }
  void pop() {
    PIRVS_ASSERT(size() > 0);
    popped_.store(popped_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  // Exact on the two cores at rest; while the other side works, a bound: the reader may see too
  // few items, the writer too many.
  size_t size() const {
    const size_t popped = popped_.load(std::memory_order_acquire);
    return pushed_.load(std::memory_order_acquire) - popped;
  }
  static constexpr size_t capacity() { return N; }

 private:
  // One cache line per writer, so that the two cores do not fight over it.
  alignas(64) std::atomic<size_t> pushed_{0};
  alignas(64) std::atomic<size_t> popped_{0};
  alignas(64) T items_[N];
};

}  // namespace pirvs
