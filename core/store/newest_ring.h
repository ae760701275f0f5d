// Queue from one writer core to one reader core that keeps the newest N items: the writer never
// waits, and overwrites the oldest item that the reader has not taken. (Ring refuses the newest.)
// In      Fill back() completely, then publish(): the next back() holds an older value.
// Out     take() gives the oldest item not yet taken or overwritten, valid until the next take().
// Errors  take: nullptr when nothing waits. lost() counts what was overwritten; exact once the
//         writer is at rest: published = taken + lost + waiting.
// Cost    One atomic exchange a call, no copy. N + 2 items.
// Source  Triple buffering (core/store/mailbox.h) with N buffers in the middle: writer and reader
//         own one buffer each, and swap it against the one in a slot.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace pirvs {

template <class T, size_t N>
class NewestRing {
  static_assert(N > 0 && N <= 4096);

 public:
  NewestRing() {
    for (size_t i = 0; i < N; ++i) slots_[i].store(i, std::memory_order_relaxed);
  }

  T& back() { return items_[back_]; }
  void publish() {
    ++published_;
    const uint64_t old =
        slots_[published_ % N].exchange(word(published_, back_), std::memory_order_acq_rel);
    if (number(old) != 0) lost_.store(lost() + 1, std::memory_order_relaxed);
    back_ = index(old);
  }

  [[nodiscard]] const T* take() {
    for (;;) {
      std::atomic<uint64_t>& slot = slots_[(taken_ + 1) % N];
      uint64_t found = slot.load(std::memory_order_relaxed);
      const uint64_t n = number(found);
      if (n <= taken_) return nullptr;
      if (n > taken_ + 1) {  // the writer has lapped the reader: the N newest are left
        taken_ = n - N;
        continue;
      }
      // Fails if the writer overwrites the item meanwhile.
      if (!slot.compare_exchange_strong(found, word(0, front_), std::memory_order_acq_rel))
        continue;
      ++taken_;
      front_ = index(found);
      return &items_[front_];
    }
  }

  uint64_t lost() const { return lost_.load(std::memory_order_relaxed); }
  static constexpr size_t capacity() { return N; }

 private:
  // A slot: the number of the item in it, from 1; 0 once it was taken; and the buffer's index.
  static constexpr int kIndexBits = 16;
  static constexpr uint64_t word(uint64_t number, uint64_t index) {
    return number << kIndexBits | index;
  }
  static constexpr uint64_t number(uint64_t word) { return word >> kIndexBits; }
  static constexpr uint64_t index(uint64_t word) { return word & ((1u << kIndexBits) - 1); }

  T items_[N + 2];
  std::atomic<uint64_t> slots_[N];
  alignas(64) uint64_t back_ = N;  // the writer's
  uint64_t published_ = 0;
  std::atomic<uint64_t> lost_{0};
  alignas(64) uint64_t front_ = N + 1;  // the reader's
  uint64_t taken_ = 0;
};

}  // namespace pirvs
