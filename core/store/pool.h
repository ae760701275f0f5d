// N slots for objects of one type, found by typed handles that go stale when the slot is released.
// In      Handles from acquire(); a default Handle is never live.
// Out     find() gives the object, or nullptr once it was released, even if the slot lives again.
//         For all: for (slot = 0; slot < capacity(); ++slot) if (T* item = at(slot)) ...
// Errors  acquire: kFull (an expected rejection: count it). release: false for a stale handle.
// Cost    O(1) each. acquire value-initializes the object in place. Slots are reused last in,
//         first out. A zeroed pool is an empty pool, so that big ones stay in .bss.
// Source  STYLE principle 8. A slot's generation is odd while it is live; 32 bits last 2^31 uses of
//         one slot: 16 days at 1500 a second.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>

#include "core/base/status.h"
#include "core/store/handle.h"

namespace pirvs {

template <class T, size_t N>
class Pool {
  static_assert(N > 0 && N < 65536 && std::is_trivially_destructible_v<T>);

 public:
  Result<Handle<T>> acquire() {
    if (size_ == N) return Status::kFull;
    // Released slots first; the list stores slot + 1, so that zero ends it.
    uint16_t slot = used_;
    if (free_ != 0) {
      slot = static_cast<uint16_t>(free_ - 1);
      free_ = next_free_[slot];
    } else {
      ++used_;
    }
    ++size_;
    ++generation_[slot];
    ::new (static_cast<void*>(&items_[slot])) T();
    return handle(slot);
  }

  bool release(Handle<T> handle) {
    if (find(handle) == nullptr) return false;
    ++generation_[handle.slot];
    next_free_[handle.slot] = free_;
    free_ = static_cast<uint16_t>(handle.slot + 1);
    --size_;
    return true;
  }

  T* find(Handle<T> handle) { return is_live(handle) ? &items_[handle.slot] : nullptr; }
  const T* find(Handle<T> handle) const { return is_live(handle) ? &items_[handle.slot] : nullptr; }

  T* at(size_t slot) { return find(handle(slot)); }
  const T* at(size_t slot) const { return find(handle(slot)); }

  // The handle of a live slot; the default handle when the slot is free.
  Handle<T> handle(size_t slot) const {
    PIRVS_ASSERT(slot < N);
    if (generation_[slot] % 2 == 0) return {};
    return {generation_[slot], static_cast<uint16_t>(slot)};
  }

  size_t size() const { return size_; }
  static constexpr size_t capacity() { return N; }

 private:
  bool is_live(Handle<T> handle) const {
    return handle.generation % 2 == 1 && handle.slot < N &&
           generation_[handle.slot] == handle.generation;
  }

  T items_[N];
  uint32_t generation_[N] = {};
  uint16_t next_free_[N] = {};
  uint16_t free_ = 0;  // head of the released slots, plus one
  uint16_t used_ = 0;  // slots from here on were never live
  size_t size_ = 0;
};

}  // namespace pirvs
